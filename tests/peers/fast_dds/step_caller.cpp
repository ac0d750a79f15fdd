// Calls /reset and /step with Fast DDS, as rmw_fastrtps_cpp maps services to DDS.
//
//     step_caller --steps NUMBER [--timeout SECONDS]
//
// Takes a number of steps with the actions 1, 2, ... 6, 0, 1, ... and prints one line of JSON: how
// many answers were right in their numbers, how often the exit was reached, and a checksum of all
// images. An episode that is over is followed by one with the next seed, from 1. Exits with 1 and
// says what was missing if all that is not done in time. The domain is that of ROS_DOMAIN_ID.

#include <charconv>
#include <cstdlib>
#include <iostream>

#include <zlib.h>

#include "client.hpp"

namespace {

uint32_t number(const std::string &name, const std::string &text) {
    uint32_t value = 0;
    const char *const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || rest != end) {
        throw std::runtime_error(name + "='" + text + "': expected a whole number");
    }
    return value;
}

struct Options {
    uint32_t steps = 0, timeout_s = 20;

    Options(int count, char **arguments) {
        for (int i = 1; i < count; i += 2) {
            const std::string name = arguments[i];
            const std::string value = i + 1 < count ? arguments[i + 1] : "";
            if (name == "--steps") {
                steps = number(name, value);
            } else if (name == "--timeout") {
                timeout_s = number(name, value);
            } else {
                throw std::runtime_error("unknown option " + name);
            }
        }
        if (steps == 0) {
            throw std::runtime_error("how many steps? give --steps NUMBER");
        }
    }
};

void add_to(uLong &checksum, const Image &image) {
    checksum = crc32(checksum, image.data.data(), image.data.size());
}

}  // namespace

int main(int count, char **arguments) try {
    const Options options(count, arguments);
    const char *const domain_id = std::getenv("ROS_DOMAIN_ID");
    const auto participant = join(number("ROS_DOMAIN_ID", domain_id ? domain_id : "0"));
    const auto deadline = Clock::now() + std::chrono::seconds(options.timeout_s);
    Client<Reset> reset(*participant, "/reset", deadline);
    Client<Step> step(*participant, "/step", deadline);

    uLong checksum = crc32(0, nullptr, 0);
    uint64_t seed = 0, episode = 0;
    uint32_t step_number = 0, right = 0, escapes = 0;
    for (uint32_t sequence = 1; sequence <= options.steps; ++sequence) {
        if (step_number == 0) {
            ++seed;
            const auto begun = reset.call({.request = seed, .seed = seed, .scenario = ""});
            episode = begun.episode;
            add_to(checksum, begun.image);
        }
        ++step_number;
        const auto action = static_cast<uint8_t>(sequence % 7);
        const auto taken = step.call({.episode = episode, .step = step_number, .action = action});
        right += taken.success && taken.episode == episode && taken.step == step_number;
        escapes += taken.terminated;
        add_to(checksum, taken.image);
        if (taken.terminated || taken.truncated) {
            step_number = 0;
        }
    }
    std::cout << "{\"right\": " << right << ", \"escapes\": " << escapes
              << ", \"checksum\": " << checksum << "}\n";
    return 0;
} catch (const std::exception &error) {
    std::cerr << "step_caller: " << error.what() << '\n';
    return 1;
}
