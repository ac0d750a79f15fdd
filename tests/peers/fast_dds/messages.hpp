// The requests and responses of the services of evac_msgs, and their serialization as CDR.

#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastcdr/exceptions/Exception.h>

#if FASTCDR_VERSION_MAJOR != 1
#error "Fast-CDR 1 required (Debian 12)"
#endif

struct Time {
    int32_t sec;
    uint32_t nanosec;

    auto fields() { return std::tie(sec, nanosec); }
};

struct Header {
    Time stamp;
    std::string frame_id;

    auto fields() { return std::tie(stamp, frame_id); }
};

struct Image {
    Header header;
    uint32_t height, width;
    std::string encoding;
    uint8_t is_bigendian;
    uint32_t step;
    std::vector<uint8_t> data;

    auto fields() { return std::tie(header, height, width, encoding, is_bigendian, step, data); }
};

struct Reset {
    static constexpr auto name = "Reset";

    struct Request {
        uint64_t request, seed;
        std::string scenario;

        auto fields() { return std::tie(request, seed, scenario); }
    };

    struct Response {
        bool success;
        uint8_t status;
        std::string message;
        uint64_t episode;
        Image image;

        auto fields() { return std::tie(success, status, message, episode, image); }
    };
};

struct Step {
    static constexpr auto name = "Step";

    struct Request {
        uint64_t episode;
        uint32_t step;
        uint8_t action;

        auto fields() { return std::tie(episode, step, action); }
    };

    struct Response {
        bool success;
        uint8_t status;
        std::string message;
        Image image;
        float reward;
        bool terminated, truncated, blocked;
        uint64_t episode;
        uint32_t step;

        auto fields() {
            return std::tie(success, status, message, image, reward, terminated, truncated, blocked,
                            episode, step);
        }
    };
};

// Visits the fields of a message in CDR order, including those of nested messages.
template <typename Value, typename Visit>
void for_each_field(Value &value, const Visit &visit) {
    if constexpr (requires { value.fields(); }) {
        std::apply([&](auto &...field) { (for_each_field(field, visit), ...); }, value.fields());
    } else {
        visit(value);
    }
}

// A message as CDR with its four-byte encapsulation header.
using Bytes = std::vector<char>;

template <typename Message>
Bytes encode(Message message) {
    using namespace eprosima::fastcdr;
    FastBuffer buffer;
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    cdr.serialize_encapsulation();
    for_each_field(message, [&](auto &field) { cdr << field; });
    return Bytes(buffer.getBuffer(), buffer.getBuffer() + cdr.getSerializedDataLength());
}

template <typename Message>
Message decode(Bytes bytes) {
    using namespace eprosima::fastcdr;
    FastBuffer buffer(bytes.data(), bytes.size());
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    Message message;
    try {
        cdr.read_encapsulation();
        for_each_field(message, [&](auto &field) { cdr >> field; });
    } catch (const exception::Exception &error) {
        throw std::runtime_error(std::string("cannot decode a message: ") + error.what());
    }
    return message;
}
