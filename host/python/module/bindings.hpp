#pragma once

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <Eigen/Geometry>
#include <utility>

#include "glenoid/types.hpp"

namespace glenoid::python {

namespace nb = nanobind;

/// Rows of samples as NumPy sees them: (n, columns), C order.
template <int Columns>
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Columns, Columns == 1 ? Eigen::ColMajor : Eigen::RowMajor>;
using Column = Eigen::VectorXd;

/// Rotations (n, 3, 3), one row-major matrix a row of `flat`; the array owns a copy.
inline nb::ndarray<nb::numpy, double> rotations_to_numpy(const Rows<9>& flat) {
  auto* data = new Rows<9>(flat);
  nb::capsule owner(data, [](void* pointer) noexcept { delete static_cast<Rows<9>*>(pointer); });
  return nb::ndarray<nb::numpy, double>(data->data(), {static_cast<size_t>(flat.rows()), 3, 3}, owner);
}

inline Eigen::Matrix<double, 1, 9> flat_rotation(const Mat3& R) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> row_major = R;
  return Eigen::Map<const Eigen::Matrix<double, 1, 9>>(row_major.data());
}

void bind_model(nb::module_& module);    ///< subject, rhythm, limits, kinematics, metric
void bind_planner(nb::module_& module);  ///< paths, planner, initial-value problem
void bind_exo(nb::module_& module);      ///< the device's joints
void bind_motion(nb::module_& module);   ///< the generator in time
void bind_rig(nb::module_& module);      ///< bridge and drives in virtual time

}  // namespace glenoid::python
