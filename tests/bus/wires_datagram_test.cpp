// The wire format of python-can's udp_multicast against bytes of python-can, its own inverse, and rubbish.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "host/bridge/can/udp_datagram.hpp"
#include "support/allocation_guard.hpp"
#include "support/environment.hpp"
#include "support/random.hpp"

namespace glenoid::can {
namespace {

using Bytes = std::vector<char>;

Bytes encoded(const Frame& frame, double time_s = 0.0) {
  DatagramEncoder encoder;
  const auto bytes = encoder.encode(frame, time_s);
  return {bytes.begin(), bytes.end()};
}

Bytes of(std::initializer_list<std::string> parts) {
  Bytes out;
  for (const std::string& part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}
std::string key(const std::string& name) { return static_cast<char>(0xA0 + name.size()) + name; }

// What python-can 4.6.1 packs for Message(timestamp=1.5, arbitration_id=0x203, is_extended_id=False, data=[0x0F, 0, 1]).
Bytes golden() {
  using namespace std::string_literals;
  return of({
      "\x8B"s,  // map of eleven
      key("timestamp"),
      "\xCB\x3F\xF8\0\0\0\0\0\0"s,  // float64 1.5
      key("arbitration_id"),
      "\xCD\x02\x03"s,  // uint16
      key("is_extended_id"),
      "\xC2"s,  // false
      key("is_remote_frame"),
      "\xC2"s,
      key("is_error_frame"),
      "\xC2"s,
      key("channel"),
      "\xC0"s,  // nil
      key("dlc"),
      "\x03"s,
      key("data"),
      "\xC4\x03\x0F\0\x01"s,  // bin8 of three bytes
      key("is_fd"),
      "\xC2"s,
      key("bitrate_switch"),
      "\xC2"s,
  });
}

Frame random_frame(test::Random& random) {
  Frame frame;
  frame.extended = random.uniform(0, 1) < 0.5;
  frame.id = static_cast<std::uint32_t>(random.uniform(0, frame.extended ? 0x20000000 : 0x800));
  frame.size = static_cast<std::uint8_t>(random.uniform(0, 9));
  frame.remote = random.uniform(0, 1) < 0.1;
  for (std::size_t k = 0; !frame.remote && k < frame.size; ++k)
    frame.data[k] = static_cast<std::uint8_t>(random.uniform(0, 256));
  return frame;
}

TEST(Datagram, DecodingInvertsEncoding) {
  test::Random random(3);
  DatagramDecoder decoder;
  for (int n = 0; n < test::test_count(2000); ++n) {
    const Frame frame = random_frame(random);
    const auto back = decoder.decode(encoded(frame, random.uniform(0, 2e9)));
    ASSERT_TRUE(back.has_value());
    ASSERT_EQ(*back, frame);
  }
}

class EdgeId : public testing::TestWithParam<std::pair<std::uint32_t, bool>> {};
TEST_P(EdgeId, IsKept) {
  Frame frame;
  frame.id = GetParam().first;
  frame.extended = GetParam().second;
  EXPECT_EQ(DatagramDecoder().decode(encoded(frame)), frame);
}
INSTANTIATE_TEST_SUITE_P(Ids, EdgeId,
                         testing::Values(std::pair{0u, false}, std::pair{0x7FFu, false}, std::pair{0u, true},
                                         std::pair{0x7FFu, true}, std::pair{0x800u, true},
                                         std::pair{0x1FFFFFFFu, true}));

TEST(Datagram, OfPythonCanIsRead) {
  Bytes bytes = golden();
  const std::string last = key("error_state_indicator") + "\xC2";
  bytes.insert(bytes.end(), last.begin(), last.end());
  const Frame expected = {.id = 0x203, .size = 3, .data = {0x0F, 0, 1}};
  EXPECT_EQ(DatagramDecoder().decode(bytes), expected);
}

TEST(Datagram, ErrorFramesKeepTheirClasses) {
  const Frame frame = {.id = 0x40, .size = 8, .error = true, .data = {0, 0, 0, 0, 0, 0, 248, 0}};
  EXPECT_EQ(DatagramDecoder().decode(encoded(frame)), frame);
}

TEST(Datagram, CutAnywhereIsRefused) {
  const Bytes whole = encoded({.id = 0x181, .size = 8});
  DatagramDecoder decoder;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(decoder.decode({whole.data(), size})) << size << " of " << whole.size() << " bytes";
  }
  EXPECT_TRUE(decoder.decode(whole)) << "a refused one leaves nothing behind";
}

TEST(Datagram, WithSomethingBehindIsRefused) {
  Bytes bytes = encoded({.id = 0x181});
  bytes.push_back('\xC0');
  EXPECT_FALSE(DatagramDecoder().decode(bytes));
}

struct Forgery {
  const char* name;
  std::string from, to;
};
class Forged : public testing::TestWithParam<Forgery> {};
TEST_P(Forged, FieldIsRefused) {
  const Frame frame = {.id = 0x12345, .size = 2, .extended = true, .data = {1, 2}};
  Bytes bytes = encoded(frame);
  ASSERT_TRUE(DatagramDecoder().decode(bytes));
  std::string text(bytes.begin(), bytes.end());
  const std::size_t at = text.find(GetParam().from);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, GetParam().from.size(), GetParam().to);
  EXPECT_FALSE(DatagramDecoder().decode(text));
}
using namespace std::string_literals;
INSTANTIATE_TEST_SUITE_P(
    Fields, Forged,
    testing::Values(Forgery{"standard_id_too_large", "is_extended_id\xC3", "is_extended_id\xC2"},
                    Forgery{"id_beyond_29_bits", "\xCE\0\x01\x23\x45"s, "\xCE\x20\0\0\0"s},
                    Forgery{"id_negative", "\xCE\0\x01\x23\x45"s, "\xD2\xFF\xFF\xFF\xFF"s},
                    Forgery{"id_no_number", "\xCE\0\x01\x23\x45"s, "\xC3"s},
                    Forgery{"id_float", "\xCE\0\x01\x23\x45"s, "\xCA\x3F\x80\0\0"s},
                    Forgery{"size_not_that_of_the_data", "dlc\x02", "dlc\x03"},
                    Forgery{"size_beyond_eight", "dlc\x02", "dlc\x09"},
                    Forgery{"data_too_long", "\xC4\x02\x01\x02", "\xC4\x09\1\2\3\4\5\6\7\x08\x09"},
                    Forgery{"data_as_text", "\xC4\x02\x01\x02", "\xA2\x01\x02"},
                    Forgery{"data_as_array", "\xC4\x02\x01\x02", "\x92\x01\x02"},
                    Forgery{"data_promised_beyond_the_end", "\xC4\x02\x01\x02", "\xC6\x7F\xFF\xFF\xFF\x01\x02"s},
                    Forgery{"extension_of_all_memory", "\xC4\x02\x01\x02", "\xC9\xFF\xFF\xFF\xFF\x01\x02"s},
                    Forgery{"flexible_data_rate", "is_fd\xC2", "is_fd\xC3"},
                    Forgery{"unknown_key", "channel", "chunnel"},
                    Forgery{"missing_key",
                            "\xA3"
                            "dlc\x02",
                            "\xA7"
                            "channel\xC0"},
                    Forgery{"nested_map", "channel\xC0", "channel\x80"},
                    Forgery{"map_longer_than_it_is", "\x8B", "\x8C"}, Forgery{"no_map", "\x8B", "\x9B"}),
    [](const auto& forgery) { return std::string(forgery.param.name); });

TEST(Datagram, RubbishNeverMakesAFrameThatCannotBe) {
  test::Random random(4);
  DatagramDecoder decoder;
  const Bytes good = encoded({.id = 0x181, .size = 8, .data = {1, 2, 3, 4, 5, 6, 7, 8}});
  for (int n = 0; n < test::test_count(20000); ++n) {
    Bytes bytes = good;
    for (int flips = 1 + n % 8; flips > 0; --flips) {
      bytes[static_cast<std::size_t>(random.uniform(0, static_cast<double>(bytes.size())))] = static_cast<char>(
          random.uniform(0, 256));
    }
    const auto frame = decoder.decode(bytes);
    if (!frame) continue;
    ASSERT_LE(frame->size, 8);
    ASSERT_LE(frame->id, frame->extended || frame->error ? 0x1FFFFFFFu : 0x7FFu);
    ASSERT_TRUE(
        std::all_of(frame->data.begin() + frame->size, frame->data.end(), [](std::uint8_t b) { return b == 0; }));
  }
}

TEST(Datagram, CodecAllocatesNothing) {
  DatagramEncoder encoder;
  DatagramDecoder decoder;
  const Frame frame = {.id = 0x181, .size = 8};
  decoder.decode(encoder.encode(frame, 0));
  const test::AllocationGuard guard;
  for (int n = 0; n < 100; ++n) decoder.decode(encoder.encode(frame, 0));
  EXPECT_EQ(guard.allocations(), 0);
}

}  // namespace
}  // namespace glenoid::can
