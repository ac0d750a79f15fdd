// Calls /reset and /step with Fast DDS, with the service mapping of rmw_fastrtps_cpp.
//
//     step_caller --steps NUMBER [--timeout SECONDS]
//
// Takes a number of steps with the actions 1, 2, ..., 6, 0, 1, ... Whenever an episode ends, starts
// another one with the next seed, counted from 1. Prints one line of JSON: the number of successful
// responses with the expected episode and step, the number of successful episodes, and a CRC-32 of
// all images. Exits with status 1 and an error if the steps take longer than the timeout
// (default: 20 s). The domain is given by ROS_DOMAIN_ID.

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
            throw std::runtime_error("--steps is missing or 0: expected a positive number");
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
    uint32_t step_number = 0, expected = 0, successes = 0;
    for (uint32_t sequence = 1; sequence <= options.steps; ++sequence) {
        if (step_number == 0) {
            ++seed;
            const auto start = reset.call({.request = seed, .seed = seed, .scenario = ""});
            episode = start.episode;
            add_to(checksum, start.image);
        }
        ++step_number;
        const auto action = static_cast<uint8_t>(sequence % 7);
        const auto result = step.call({.episode = episode, .step = step_number, .action = action});
        expected += result.success && result.episode == episode && result.step == step_number;
        successes += result.terminated;
        add_to(checksum, result.image);
        if (result.terminated || result.truncated) {
            step_number = 0;
        }
    }
    std::cout << "{\"right\": " << expected << ", \"escapes\": " << successes
              << ", \"checksum\": " << checksum << "}\n";
    return 0;
} catch (const std::exception &error) {
    std::cerr << "step_caller: " << error.what() << '\n';
    return 1;
}
