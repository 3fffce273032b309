#pragma once

#include <string>

#include "host/drives/profile.hpp"

namespace glenoid::drives {

/// Electronic data sheet (CiA 306) of a drive family, written from the table its dictionary is made from.
/// @throws std::invalid_argument as `Drive` does, for a profile that names an object the table lacks.
std::string electronic_data_sheet(const Profile& profile);

}  // namespace glenoid::drives
