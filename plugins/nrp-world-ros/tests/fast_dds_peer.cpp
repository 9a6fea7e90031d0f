// A participant of Fast DDS, with its defaults and what ROS 2's rmw_fastrtps_cpp sets. Bytes are hexadecimal.
//
// fast_dds_peer DOMAIN hear|latched TOPIC TYPE      prints the first message on a topic, if need be a kept one
// fast_dds_peer DOMAIN say TOPIC TYPE BYTES         sends a message
// fast_dds_peer DOMAIN call SERVICE TYPE BYTES...   calls a service, once with each request, and prints the answers
#include <chrono>
#include <cstring>
#include <iostream>
#include <string>
#include <thread>
#include <vector>
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

using namespace eprosima::fastdds::dds;
using eprosima::fastrtps::rtps::InstanceHandle_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;
using eprosima::fastrtps::rtps::WriteParams;
using Bytes = std::vector<uint8_t>;

class Raw : public TopicDataType {
public:
    explicit Raw(const std::string& name) { setName(name.c_str()); m_typeSize = 4096; m_isGetKeyDefined = false; }
    bool serialize(void* data, SerializedPayload_t* to) override {
        const Bytes& bytes = *static_cast<Bytes*>(data);
        to->reserve(bytes.size());
        memcpy(to->data, bytes.data(), bytes.size());
        to->length = bytes.size();
        to->encapsulation = CDR_LE;
        return true;
    }
    bool deserialize(SerializedPayload_t* from, void* data) override {
        static_cast<Bytes*>(data)->assign(from->data, from->data + from->length);
        return true;
    }
    std::function<uint32_t()> getSerializedSizeProvider(void* data) override {
        return [data] { return static_cast<uint32_t>(static_cast<Bytes*>(data)->size()); };
    }
    void* createData() override { return new Bytes; }
    void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
    bool getKey(void*, InstanceHandle_t*, bool) override { return false; }
};

Bytes unhex(const std::string& text) {
    if (text[0] == '@') return Bytes(std::stoi(text.substr(1)), 7);  // so many bytes
    Bytes bytes;
    for (size_t i = 0; i + 1 < text.size(); i += 2) bytes.push_back(std::stoi(text.substr(i, 2), nullptr, 16));
    return bytes;
}

void show(const Bytes& bytes) {
    for (uint8_t each : bytes) printf("%02x", each);
    printf("\n"); fflush(stdout);
}

struct Peer {
    DomainParticipant* participant;
    explicit Peer(int domain) { participant = DomainParticipantFactory::get_instance()->create_participant(domain, PARTICIPANT_QOS_DEFAULT); }
    Topic* topic(const std::string& name, const std::string& type) {
        TypeSupport support(new Raw(type));
        participant->register_type(support);
        return participant->create_topic(name, type, TOPIC_QOS_DEFAULT);
    }
    DataReader* reader(const std::string& name, const std::string& type, bool latched = false) {
        DataReaderQos qos;
        qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
        qos.history().depth = 10;
        if (latched) qos.durability().kind = TRANSIENT_LOCAL_DURABILITY_QOS;
        qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
        qos.data_sharing().off();
        return participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT)->create_datareader(topic(name, type), qos);
    }
    DataWriter* writer(const std::string& name, const std::string& type) {
        DataWriterQos qos;
        qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
        qos.history().depth = 10;
        qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
        qos.publish_mode().kind = ASYNCHRONOUS_PUBLISH_MODE;
        qos.data_sharing().off();
        return participant->create_publisher(PUBLISHER_QOS_DEFAULT)->create_datawriter(topic(name, type), qos);
    }
};

template <typename Done> bool until(Done done, double seconds) {
    auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!done()) {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return true;
}

bool take(DataReader* reader, Bytes& bytes, SampleInfo& info) {
    return reader->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK && info.valid_data;
}

bool matched(DataWriter* writer) { PublicationMatchedStatus status; writer->get_publication_matched_status(status); return status.current_count > 0; }
bool matched(DataReader* reader) { SubscriptionMatchedStatus status; reader->get_subscription_matched_status(status); return status.current_count > 0; }

int main(int argc, char** argv) {
    std::string what = argv[2], name = argv[3], type = argv[4];
    Peer peer(std::stoi(argv[1]));
    Bytes bytes; SampleInfo info;
    if (what == "hear" || what == "latched") {
        DataReader* reader = peer.reader(name, type, what == "latched");
        printf("ready\n"); fflush(stdout);
        if (!until([&] { return take(reader, bytes, info); }, 10)) { printf("nothing\n"); return 1; }
        show(bytes);
    } else if (what == "say") {
        DataWriter* writer = peer.writer(name, type);
        printf("ready\n"); fflush(stdout);
        if (!until([&] { return matched(writer); }, 10)) { printf("nobody\n"); return 1; }
        bytes = unhex(argv[5]);
        writer->write(&bytes);
        std::this_thread::sleep_for(std::chrono::seconds(1));
    } else if (what == "call") {  // as rmw_fastrtps_shared_cpp sends a request and takes a response
        DataReader* reader = peer.reader("rr" + name + "Reply", type + "_Response_");
        DataWriter* writer = peer.writer("rq" + name + "Request", type + "_Request_");
        if (!until([&] { return matched(writer) && matched(reader); }, 10)) { printf("no server\n"); return 1; }
        for (int i = 5; i < argc; ++i) {
            bytes = unhex(argv[i]);
            WriteParams params;
            params.related_sample_identity().writer_guid() = reader->guid();
            writer->write(&bytes, params);
            auto sequence = params.sample_identity().sequence_number();
            bool answered = until([&] {
                while (take(reader, bytes, info)) {
                    auto& id = info.related_sample_identity;
                    if ((id.writer_guid() == reader->guid() || id.writer_guid() == writer->guid()) && id.sequence_number() == sequence) return true;
                }
                return false;
            }, 10);
            if (!answered) { printf("no answer\n"); return 1; }
            show(bytes);
        }
    }
}
