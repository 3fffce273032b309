#include "log.hpp"

#include <array>
#include <cstring>

namespace glenoid::fmu {
namespace {

/// LogCategories of modelDescription.xml, indexed by outcome (a test compares them).
constexpr std::array<const char*, 4> kCategories = {"logEvents", "logStatusWarning", "logStatusDiscard",
                                                    "logStatusError"};

}  // namespace

Outcome Log::select(bool on, std::size_t count, const char* const categories[]) noexcept {
  Outcome outcome = Outcome::Ok;
  unsigned selected = count == 0 || categories == nullptr ? ~0U : 0U;
  for (std::size_t i = 0; selected != ~0U && i < count; ++i) {
    unsigned bit = 0;
    for (unsigned k = 0; k < kCategories.size(); ++k) {
      if (categories[i] != nullptr && std::strcmp(categories[i], kCategories[k]) == 0) bit = 1U << k;
    }
    if (bit == 0) outcome = Outcome::Warning;
    selected |= bit;
  }
  on_ = on;
  selected_ = selected;
  return outcome;
}

void Log::write(Outcome outcome, const char* message) const {
  const auto index = static_cast<unsigned>(outcome);
  if (on_ && sink_ != nullptr && (selected_ >> index & 1U) != 0) sink_->write(outcome, kCategories[index], message);
}

}  // namespace glenoid::fmu
