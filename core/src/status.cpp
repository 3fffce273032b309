#include "glenoid/status.hpp"

namespace glenoid {

const char* to_string(Status status) noexcept {
  switch (status) {
    case Status::Ok:
      return "Ok";
    case Status::NotFinite:
      return "NotFinite";
    case Status::OutOfRange:
      return "OutOfRange";
    case Status::TargetUnreachable:
      return "TargetUnreachable";
    case Status::LimitsInfeasible:
      return "LimitsInfeasible";
    case Status::ExoInfeasible:
      return "ExoInfeasible";
    case Status::NoConvergence:
      return "NoConvergence";
    case Status::NotAvailable:
      return "NotAvailable";
  }
  return "Unknown";
}

}  // namespace glenoid
