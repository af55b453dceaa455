// Python values as the payloads of commands.
#include <nanobind/stl/string.h>

#include "convert.hpp"
#include "dvrk/bindings.hpp"

namespace nb = nanobind;

namespace palpate::bindings {
namespace {

using dvrk::Payload;

JointVector numbers(const nb::object& value) {
  const Eigen::VectorXd all = nb::cast<VectorArg>(value).values;
  return dvrk::joints({all.data(), static_cast<std::size_t>(all.size())});
}

Vec3 vector3(const nb::object& value, const char* name) {
  const Eigen::VectorXd all = nb::cast<VectorArg>(value).values;
  if (all.size() != 3) {
    throw std::invalid_argument(std::string(name) + " must have shape (3,); got (" + std::to_string(all.size()) + ",)");
  }
  return all;
}

/// The numbers of a square matrix (n, n), row by row.
Eigen::VectorXd square(const nb::object& value, Eigen::Index n) {
  const auto all = nb::cast<VectorArg>(nb::module_::import_("numpy").attr("ravel")(value)).values;
  if (all.size() != n * n) {
    const std::string shape = "(" + std::to_string(n) + ", " + std::to_string(n) + ")";
    throw std::invalid_argument("the matrix must have shape " + shape + "; got " + std::to_string(all.size()) +
                                " numbers");
  }
  return all;
}

Mat3 raw_rotation(const nb::object& value) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(square(value, 3).data());
}

Wrench raw_wrench(const nb::object& value) { return wrench(nb::cast<VectorArg>(value).values, "wrench"); }

dvrk::HalfPlane half_plane(const nb::dict& gains, const char* side) {
  dvrk::HalfPlane h;
  if (!gains.contains(side)) return h;
  const auto given = nb::cast<nb::dict>(gains[side]);
  const auto read = [&](const char* name, Vec3& out) {
    if (given.contains(name)) out = vector3(given[name], name);
  };
  read("p", h.p);
  read("d", h.d);
  read("bias", h.bias);
  read("deadband", h.deadband);
  return h;
}

}  // namespace

Pose raw_pose(const nb::object& value) {
  const Eigen::VectorXd all = square(value, 4);
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> X(all.data());
  return {X.topLeftCorner<3, 3>(), X.topRightCorner<3, 1>()};
}

dvrk::Impedance impedance(const nb::dict& gains) {
  dvrk::Impedance i;
  if (gains.contains("force_orientation")) i.R_force = raw_rotation(nb::object(gains["force_orientation"]));
  if (gains.contains("force_position")) i.p_force = vector3(gains["force_position"], "force_position");
  if (gains.contains("torque_orientation")) i.R_torque = raw_rotation(nb::object(gains["torque_orientation"]));
  i.position_positive = half_plane(gains, "position_positive");
  i.position_negative = half_plane(gains, "position_negative");
  i.orientation_positive = half_plane(gains, "orientation_positive");
  i.orientation_negative = half_plane(gains, "orientation_negative");
  return i;
}

namespace {

void fill_cartesian(dvrk::Command& c, const nb::dict& parts) {
  c.pose_is_valid = parts.contains("pose");
  c.twist_is_valid = parts.contains("twist");
  c.wrench_is_valid = parts.contains("wrench");
  if (c.pose_is_valid) c.X = raw_pose(parts["pose"]);
  if (c.wrench_is_valid) c.F = raw_wrench(parts["wrench"]);
  if (!c.twist_is_valid) return;
  const Wrench V = raw_wrench(parts["twist"]);
  c.V = {V.f, V.t};
}

void fill(dvrk::Command& c, const dvrk::VerbEntry& entry, const nb::object& value, const nb::object& velocity) {
  switch (entry.payload) {
    case Payload::none:
      break;
    case Payload::flag:
      c.flag = nb::cast<bool>(value);
      break;
    case Payload::value:
      c.value = nb::cast<double>(value);
      break;
    case Payload::text:
      c.text = std::string_view(nb::cast<std::string>(value));
      break;
    case Payload::button:
      c.button = nb::cast<int>(value);
      break;
    case Payload::numbers:
      c.position = numbers(value);
      break;
    case Payload::joints:
      (entry.name.ends_with("jf") ? c.effort : c.position) = numbers(value);
      if (!velocity.is_none()) c.velocity = numbers(velocity);
      break;
    case Payload::pose:
      c.X = raw_pose(value);
      break;
    case Payload::rotation:
      c.X.R = raw_rotation(value);
      break;
    case Payload::wrench:
      c.F = raw_wrench(value);
      break;
    case Payload::impedance:
      c.impedance = impedance(nb::cast<nb::dict>(value));
      break;
    case Payload::cartesian:
      fill_cartesian(c, nb::cast<nb::dict>(value));
      break;
    case Payload::operating:
      break;
  }
}

}  // namespace

dvrk::Command command(const dvrk::Address& to, const dvrk::VerbEntry& verb, const nb::object& value,
                      const nb::object& velocity) {
  dvrk::Command c;
  c.to = to;
  c.verb = verb.verb;
  fill(c, verb, value, velocity);
  return c;
}

}  // namespace palpate::bindings
