#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <new>

#include "instance.hpp"

namespace glenoid::fmu {

/// New instance behind an opaque handle, or NULL with a message: wrong token, wrong interface type, no memory.
template <class MakeSink>
Instance* instantiate(const char* function, const char* token, bool co_simulation, bool logging,
                      MakeSink&& make_sink) noexcept {
  try {
    auto instance = std::make_unique<Instance>(make_sink(), logging);
    if (!co_simulation) {
      (void)instance->fail(function, "only co-simulation is offered");
      return nullptr;
    }
    if (token == nullptr || std::strcmp(token, kInstantiationToken) != 0) {
      Text text;
      text << "token = " << (token == nullptr ? "(none)" : token) << ": must be " << kInstantiationToken
           << "; description and library are of different versions";
      (void)instance->fail(function, text.c_str());
      return nullptr;
    }
    return instance.release();
  } catch (...) {
    return nullptr;  // no memory: there is nothing to log with
  }
}

/// Saves into *state; a handle that is there already is used again.
Outcome get_state(const Instance& instance, const char* function, void** state);
Outcome set_state(Instance& instance, const char* function, const void* state);
Outcome free_state(void** state) noexcept;
Outcome state_size(const Instance& instance, const char* function, const void* state, std::size_t* size);
Outcome write_state(const Instance& instance, const char* function, const void* state, unsigned char* bytes,
                    std::size_t size);
/// @return Error for bytes that are not a complete state of this FMU; *state is then unchanged, the instance ended.
Outcome read_state(Instance& instance, const char* function, const unsigned char* bytes, std::size_t size, void** state);

}  // namespace glenoid::fmu
