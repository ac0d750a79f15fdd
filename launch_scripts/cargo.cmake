# Included by the CMakeLists.txt of each package that has a program: builds all programs with cargo and installs
# the one that the variable `program` names.
#
# These packages all run the same command in the same target directory, `target` in the repository unless
# CARGO_TARGET_DIR is set, so cargo compiles each crate only once.
get_filename_component(repository "${CMAKE_CURRENT_LIST_DIR}/.." ABSOLUTE)
set(target_directory "${repository}/target")
if(DEFINED ENV{CARGO_TARGET_DIR})
  get_filename_component(target_directory "$ENV{CARGO_TARGET_DIR}" ABSOLUTE BASE_DIR "${repository}")
endif()

# Keeps colcon from searching the build artifacts for packages.
file(MAKE_DIRECTORY "${target_directory}")
file(TOUCH "${target_directory}/COLCON_IGNORE")

add_custom_target(${PROJECT_NAME} ALL
  COMMAND ${CMAKE_COMMAND} -E env "CARGO_TARGET_DIR=${target_directory}"
    "${repository}/launch_scripts/build.sh"
  VERBATIM
)
install(PROGRAMS "${target_directory}/release/${program}" DESTINATION lib/${PROJECT_NAME})
