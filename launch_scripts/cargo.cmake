# Included by the CMakeLists.txt of our packages: builds all programs by cargo, and installs the one whose
# name is in `program`.
#
# Every package runs the same command in the same target directory, the repository's own unless
# CARGO_TARGET_DIR says otherwise, so cargo compiles each crate once, whichever package colcon builds first.
get_filename_component(repository "${CMAKE_CURRENT_LIST_DIR}/.." ABSOLUTE)
set(target_directory "${repository}/target")
if(DEFINED ENV{CARGO_TARGET_DIR})
  get_filename_component(target_directory "$ENV{CARGO_TARGET_DIR}" ABSOLUTE BASE_DIR "${repository}")
endif()

# colcon need not look for packages among build products.
file(MAKE_DIRECTORY "${target_directory}")
file(TOUCH "${target_directory}/COLCON_IGNORE")

add_custom_target(${PROJECT_NAME} ALL
  COMMAND ${CMAKE_COMMAND} -E env "CARGO_TARGET_DIR=${target_directory}"
    "${repository}/launch_scripts/build.sh"
  VERBATIM
)
install(PROGRAMS "${target_directory}/release/${program}" DESTINATION lib/${PROJECT_NAME})
