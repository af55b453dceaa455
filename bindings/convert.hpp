// Converts between numpy arrays and the core's Eigen types of bounded size. Errors name the argument and both shapes.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include "palpate/types/spatial.hpp"
#include "types.hpp"

namespace palpate::bindings {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;
using Matrix4 = Eigen::Matrix4d;
using Rows3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using RowMat3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMat4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

/// A vector argument: an array, a list or a tuple of numbers.
struct VectorArg {
  Eigen::VectorXd values;
  operator const Eigen::VectorXd&() const { return values; }  // NOLINT(google-explicit-constructor)
};

/// A joint vector of n entries (n < 0: any number up to kMaxJoints).
inline JointVector joint_vector(const Eigen::VectorXd& values, const char* name, Eigen::Index n = -1) {
  if (n >= 0 ? values.size() != n : values.size() > kMaxJoints) {
    throw std::invalid_argument(
        std::string(name) + " must have " +
        (n >= 0 ? "shape (" + std::to_string(n) + ",)" : "at most " + std::to_string(kMaxJoints) + " entries") +
        ", one per joint; got shape (" + std::to_string(values.size()) + ",)");
  }
  return values;
}

inline JointMatrix joint_matrix(const Eigen::MatrixXd& values, const char* name) {
  if (values.rows() != values.cols() || values.rows() > kMaxJoints) {
    throw std::invalid_argument(std::string(name) + " must be square, for at most " + std::to_string(kMaxJoints) +
                                " joints; got shape (" + std::to_string(values.rows()) + ", " +
                                std::to_string(values.cols()) + ")");
  }
  return values;
}

inline Matrix4 to_matrix(const Pose& X) {
  Matrix4 m = Matrix4::Identity();
  m.topLeftCorner<3, 3>() = X.R;
  m.topRightCorner<3, 1>() = X.p;
  return m;
}

inline Pose to_pose(const Matrix4& m, const char* name) {
  const Pose X{m.topLeftCorner<3, 3>(), m.topRightCorner<3, 1>()};
  const bool affine = m.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), 1e-9);
  const bool rotation = (X.R * X.R.transpose()).isApprox(Mat3::Identity(), 1e-6) && X.R.determinant() > 0.0;
  if (!m.allFinite() || !affine || !rotation) {
    throw std::invalid_argument(std::string(name) +
                                " must be a pose: finite, a rotation matrix in [:3, :3] and last row 0 0 0 1");
  }
  return X;
}

/// A force (3,), or a force and a moment (6,).
inline Wrench wrench(const Eigen::VectorXd& values, const char* name) {
  if (values.size() != 3 && values.size() != 6) {
    throw std::invalid_argument(std::string(name) + " must have shape (3,) or (6,); got (" +
                                std::to_string(values.size()) + ",)");
  }
  return {values.head<3>(), values.size() == 6 ? Vec3(values.tail<3>()) : Vec3(Vec3::Zero())};
}

inline Vec6 to_vector(const Wrench& F) {
  Vec6 v;
  v << F.f, F.t;
  return v;
}

/// Binds a joint-vector field of a struct as a numpy array that can be read and assigned.
template <typename Class, typename Struct>
void joint_field(Class& c, const char* name, JointVector Struct::* field, const char* doc) {
  c.def_prop_rw(
      name, [field](const Struct& s) -> Eigen::VectorXd { return s.*field; },
      [field, name](Struct& s, const Eigen::VectorXd& v) { s.*field = joint_vector(v, name); }, doc);
}

}  // namespace palpate::bindings

namespace nanobind::detail {

template <>
struct type_caster<palpate::bindings::VectorArg> {
  NB_TYPE_CASTER(palpate::bindings::VectorArg, const_name("numpy.typing.ArrayLike"))

  bool from_python(handle source, uint8_t flags, cleanup_list* cleanup) noexcept {
    try {
      const object array = module_::import_("numpy").attr("asarray")(source, "float64");
      make_caster<Eigen::VectorXd> vector;
      if (!vector.from_python(array, flags, cleanup)) {
        return false;
      }
      value.values = std::move(vector.value);
      return true;
    } catch (const python_error&) {
      return false;  // not numbers: nanobind reports the expected signature
    }
  }
};

}  // namespace nanobind::detail
