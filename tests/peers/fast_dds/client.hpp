// A client of a service with Fast DDS, as rmw_fastrtps_cpp maps services to DDS: requests and
// answers are samples of two topics; which of them belong together is said beside the data.

#pragma once

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <fastdds/rtps/common/WriteParams.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include "messages.hpp"

namespace fastdds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

using Clock = std::chrono::steady_clock;
using eprosima::fastrtps::types::ReturnCode_t;

// Others hear at once that a participant is gone.
struct Leave {
    void operator()(fastdds::DomainParticipant *participant) const {
        participant->delete_contained_entities();
        fastdds::DomainParticipantFactory::get_instance()->delete_participant(participant);
    }
};

using Participant = std::unique_ptr<fastdds::DomainParticipant, Leave>;

// The keys of the enclave that ROS's variables name, which must be ROS_SECURITY_ENCLAVE_OVERRIDE; none
// without ROS_SECURITY_ENABLE=true.
inline rtps::PropertyPolicy security() {
    const auto variable = [](const char *name) {
        const char *const value = std::getenv(name);
        return std::string(value ? value : "");
    };
    rtps::PropertyPolicy policy;
    if (variable("ROS_SECURITY_ENABLE") != "true") {
        return policy;
    }
    const std::string directory = "file://" + variable("ROS_SECURITY_KEYSTORE") + "/enclaves" +
                                  variable("ROS_SECURITY_ENCLAVE_OVERRIDE") + "/";
    const std::string authentication = "dds.sec.auth.builtin.PKI-DH.";
    const std::string access = "dds.sec.access.builtin.Access-Permissions.";
    const std::pair<std::string, std::string> properties[] = {
        {"dds.sec.auth.plugin", "builtin.PKI-DH"},
        {"dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC"},
        {"dds.sec.access.plugin", "builtin.Access-Permissions"},
        {authentication + "identity_ca", directory + "identity_ca.cert.pem"},
        {authentication + "identity_certificate", directory + "cert.pem"},
        {authentication + "private_key", directory + "key.pem"},
        {access + "permissions_ca", directory + "permissions_ca.cert.pem"},
        {access + "governance", directory + "governance.p7s"},
        {access + "permissions", directory + "permissions.p7s"},
    };
    for (const auto &[name, value] : properties) {
        policy.properties().emplace_back(name, value);
    }
    return policy;
}

// Joins a domain as ROS 2 does for ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST, but for shared memory:
// participants find each other at the well-known unicast ports of loopback, and nothing leaves it.
inline Participant join(uint32_t domain_id) {
    const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList = {"127.0.0.1"};
    udp->maxInitialPeersRange = 32;
    rtps::Locator_t loopback;
    rtps::IPLocator::setIPv4(loopback, "127.0.0.1");

    fastdds::DomainParticipantQos qos;
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports = {udp};
    auto &discovery = qos.wire_protocol().builtin;
    // With an address of its own it asks for no multicast.
    discovery.metatrafficUnicastLocatorList.push_back(loopback);
    discovery.initialPeersList.push_back(loopback);
    qos.properties(security());
    const auto factory = fastdds::DomainParticipantFactory::get_instance();
    Participant participant(factory->create_participant(domain_id, qos));
    if (!participant) {
        throw std::runtime_error("cannot join DDS domain " + std::to_string(domain_id));
    }
    return participant;
}

// A type that Fast DDS knows by name only: its messages come and go as the bytes that they are.
class Encoded : public fastdds::TopicDataType {
public:
    explicit Encoded(const std::string &name) {
        setName(name.c_str());
        // What is longer gets its room when it comes.
        m_typeSize = 256;
        // ROS 2 does not describe its types to DDS.
        auto_fill_type_object(false);
        auto_fill_type_information(false);
    }

    bool serialize(void *data, rtps::SerializedPayload_t *payload) override {
        const Bytes &bytes = *static_cast<Bytes *>(data);
        if (bytes.size() > payload->max_size) {
            return false;
        }
        std::copy(bytes.begin(), bytes.end(), payload->data);
        payload->length = bytes.size();
        return true;
    }

    bool deserialize(rtps::SerializedPayload_t *payload, void *data) override {
        static_cast<Bytes *>(data)->assign(payload->data, payload->data + payload->length);
        return true;
    }

    std::function<uint32_t()> getSerializedSizeProvider(void *data) override {
        return [data] { return static_cast<Bytes *>(data)->size(); };
    }

    void *createData() override { return new Bytes; }
    void deleteData(void *data) override { delete static_cast<Bytes *>(data); }
    bool getKey(void *, rtps::InstanceHandle_t *, bool) override { return false; }
};

// The profile that ROS 2 has for services.
template <typename Qos>
Qos for_services(Qos qos) {
    qos.reliability().kind = fastdds::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = fastdds::VOLATILE_DURABILITY_QOS;
    qos.history().kind = fastdds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = 10;
    // Messages have no greatest length.
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return qos;
}

// A client of a service, such as Client<Step> of /step. All of its waiting ends at the deadline.
template <typename Service>
class Client {
public:
    Client(fastdds::DomainParticipant &participant, const std::string &service,
           Clock::time_point deadline)
        : service_(service), deadline_(deadline) {
        const auto topic = [&](const std::string &name, const std::string &half) {
            const std::string type = std::string("evac_msgs::srv::dds_::") + Service::name + half;
            fastdds::TypeSupport(new Encoded(type)).register_type(&participant);
            return participant.create_topic(name, type, fastdds::TOPIC_QOS_DEFAULT);
        };
        const auto requests = topic("rq" + service + "Request", "_Request_");
        const auto answers = topic("rr" + service + "Reply", "_Response_");
        const auto publisher = participant.create_publisher(fastdds::PUBLISHER_QOS_DEFAULT);
        const auto subscriber = participant.create_subscriber(fastdds::SUBSCRIBER_QOS_DEFAULT);
        reader_ =
            subscriber->create_datareader(answers, for_services(fastdds::DATAREADER_QOS_DEFAULT));
        writer_ =
            publisher->create_datawriter(requests, for_services(fastdds::DATAWRITER_QOS_DEFAULT));
        if (!reader_ || !writer_) {
            throw std::runtime_error("there can be no client of " + service);
        }
        while (!is_served()) {
            if (Clock::now() > deadline) {
                throw std::runtime_error("nobody serves " + service);
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
    }

    // The answer to a request, which is repeated until there is one: the first answer may be lost,
    // since the server does not wait until it has found the client's reader.
    typename Service::Response call(const typename Service::Request &request) {
        Bytes bytes = encode(request);
        std::optional<rtps::SequenceNumber_t> first;
        while (Clock::now() < deadline_) {
            // It bears a number as every sample does, and says besides who hears the answer.
            rtps::WriteParams parameters;
            parameters.related_sample_identity().writer_guid(reader_->guid());
            if (!writer_->write(&bytes, parameters)) {
                throw std::runtime_error("a request to " + service_ + " cannot be sent");
            }
            first = first.value_or(parameters.sample_identity().sequence_number());
            const auto until = std::min(deadline_, Clock::now() + std::chrono::seconds(1));
            if (const auto answer = answer_since(*first, until)) {
                return decode<typename Service::Response>(*answer);
            }
        }
        throw std::runtime_error("no answer from " + service_);
    }

private:
    bool is_served() const {
        fastdds::PublicationMatchedStatus servers;
        fastdds::SubscriptionMatchedStatus answering;
        writer_->get_publication_matched_status(servers);
        reader_->get_subscription_matched_status(answering);
        return servers.current_count > 0 && answering.current_count > 0;
    }

    // The answer to a request of this client from the first one on.
    std::optional<Bytes> answer_since(const rtps::SequenceNumber_t &first,
                                      Clock::time_point until) {
        Bytes bytes;
        fastdds::SampleInfo info;
        for (;;) {
            while (reader_->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK) {
                const auto &request = info.related_sample_identity;
                // Everybody's answers come by one topic; and a server that leaves says so by a
                // sample without data.
                if (info.valid_data && request.writer_guid() == reader_->guid() &&
                    request.sequence_number() >= first) {
                    return bytes;
                }
            }
            const std::chrono::duration<double> remaining = until - Clock::now();
            if (remaining.count() <= 0) {
                return std::nullopt;
            }
            reader_->wait_for_unread_message(eprosima::fastrtps::Duration_t(remaining.count()));
        }
    }

    std::string service_;
    Clock::time_point deadline_;
    fastdds::DataReader *reader_;
    fastdds::DataWriter *writer_;
};
