// A Fast DDS service client with the service mapping of rmw_fastrtps_cpp: requests and
// responses are samples on two topics. The related sample identity in their metadata matches each
// response to its request.

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

// Deletes a participant properly, so that the other participants learn of its departure.
struct DeleteParticipant {
    void operator()(fastdds::DomainParticipant *participant) const {
        participant->delete_contained_entities();
        fastdds::DomainParticipantFactory::get_instance()->delete_participant(participant);
    }
};

using Participant = std::unique_ptr<fastdds::DomainParticipant, DeleteParticipant>;

// Returns the security properties for the enclave ROS_SECURITY_ENCLAVE_OVERRIDE in the keystore
// ROS_SECURITY_KEYSTORE; empty unless ROS_SECURITY_ENABLE is "true".
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

// Joins a domain as ROS 2 does for ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST, but without shared
// memory: participants discover each other only at the well-known unicast ports of loopback.
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
    // With an explicit address, Fast DDS does not use multicast.
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

// A type that is opaque to Fast DDS: its samples are byte strings that are already serialized.
class Encoded : public fastdds::TopicDataType {
public:
    explicit Encoded(const std::string &name) {
        setName(name.c_str());
        // The initial buffer size; the memory policy reallocates for longer samples.
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

// Applies the QoS profile of ROS 2 services.
template <typename Qos>
Qos for_services(Qos qos) {
    qos.reliability().kind = fastdds::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = fastdds::VOLATILE_DURABILITY_QOS;
    qos.history().kind = fastdds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = 10;
    // Messages have no maximum length.
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return qos;
}

// A client of a service, such as Client<Step> for /step. Throws std::runtime_error if it cannot be
// created, or if no server is found or a response has not arrived by the deadline.
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
        const auto responses = topic("rr" + service + "Reply", "_Response_");
        const auto publisher = participant.create_publisher(fastdds::PUBLISHER_QOS_DEFAULT);
        const auto subscriber = participant.create_subscriber(fastdds::SUBSCRIBER_QOS_DEFAULT);
        reader_ =
            subscriber->create_datareader(responses, for_services(fastdds::DATAREADER_QOS_DEFAULT));
        writer_ =
            publisher->create_datawriter(requests, for_services(fastdds::DATAWRITER_QOS_DEFAULT));
        if (!reader_ || !writer_) {
            throw std::runtime_error("cannot create a client of " + service);
        }
        while (!is_served()) {
            if (Clock::now() > deadline) {
                throw std::runtime_error("no server for " + service);
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
    }

    // Sends a request, repeats it every second until a response arrives, and returns the response.
    // The first response may be lost, since the server does not wait until it has matched the
    // client's reader.
    typename Service::Response call(const typename Service::Request &request) {
        Bytes bytes = encode(request);
        std::optional<rtps::SequenceNumber_t> first;
        while (Clock::now() < deadline_) {
            // Tells the server which reader expects the response. The sample's sequence number
            // identifies the request.
            rtps::WriteParams parameters;
            parameters.related_sample_identity().writer_guid(reader_->guid());
            if (!writer_->write(&bytes, parameters)) {
                throw std::runtime_error("cannot send a request to " + service_);
            }
            first = first.value_or(parameters.sample_identity().sequence_number());
            const auto until = std::min(deadline_, Clock::now() + std::chrono::seconds(1));
            if (const auto response = response_since(*first, until)) {
                return decode<typename Service::Response>(*response);
            }
        }
        throw std::runtime_error("no response from " + service_);
    }

private:
    bool is_served() const {
        fastdds::PublicationMatchedStatus servers;
        fastdds::SubscriptionMatchedStatus repliers;
        writer_->get_publication_matched_status(servers);
        reader_->get_subscription_matched_status(repliers);
        return servers.current_count > 0 && repliers.current_count > 0;
    }

    // Returns the response to a request of this client with a sequence number of at least `first`.
    std::optional<Bytes> response_since(const rtps::SequenceNumber_t &first,
                                        Clock::time_point until) {
        Bytes bytes;
        fastdds::SampleInfo info;
        for (;;) {
            while (reader_->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK) {
                const auto &request = info.related_sample_identity;
                // The topic carries the responses to all clients, and a departing server causes a
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
