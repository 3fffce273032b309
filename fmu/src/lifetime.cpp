#include "lifetime.hpp"

namespace glenoid::fmu {
namespace {

constexpr const char* kNull = "null pointer";

const Snapshot* snapshot_of(const void* state) noexcept { return static_cast<const Snapshot*>(state); }

}  // namespace

Outcome get_state(const Instance& instance, const char* function, void** state) {
  if (state == nullptr) return instance.refuse(function, kNull);
  if (*state == nullptr) *state = new Snapshot();
  instance.save(*static_cast<Snapshot*>(*state));
  return Outcome::Ok;
}

Outcome set_state(Instance& instance, const char* function, const void* state) {
  if (state == nullptr) return instance.refuse(function, kNull);
  return instance.restore(function, *snapshot_of(state));
}

Outcome free_state(void** state) noexcept {
  if (state == nullptr) return Outcome::Ok;
  delete static_cast<Snapshot*>(*state);
  *state = nullptr;
  return Outcome::Ok;
}

Outcome state_size(const Instance& instance, const char* function, const void* state, std::size_t* size) {
  if (state == nullptr || size == nullptr) return instance.refuse(function, kNull);
  *size = serialized_size(*snapshot_of(state));
  return Outcome::Ok;
}

Outcome write_state(const Instance& instance, const char* function, const void* state, unsigned char* bytes,
                    std::size_t size) {
  if (state == nullptr || bytes == nullptr) return instance.refuse(function, kNull);
  const Snapshot& snapshot = *snapshot_of(state);
  if (const std::size_t needed = serialized_size(snapshot); size < needed) {
    Text text;
    text << "size = " << size << " bytes: must be at least " << needed << " bytes";
    return instance.refuse(function, text.c_str());
  }
  serialize(snapshot, bytes);
  return Outcome::Ok;
}

Outcome read_state(Instance& instance, const char* function, const unsigned char* bytes, std::size_t size,
                   void** state) {
  if (bytes == nullptr || state == nullptr) return instance.refuse(function, kNull);
  auto snapshot = std::make_unique<Snapshot>();
  if (const char* problem = deserialize(bytes, size, *snapshot); problem != nullptr) {
    Text text;
    text << "serialized state of " << size << " bytes: " << problem;
    return instance.fail(function, text.c_str());
  }
  (void)free_state(state);
  *state = snapshot.release();
  return Outcome::Ok;
}

}  // namespace glenoid::fmu
