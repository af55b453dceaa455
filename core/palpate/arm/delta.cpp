#include "palpate/arm/delta.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "palpate/arm/parameters.hpp"

namespace palpate::arm {
namespace {

constexpr int kArms = 3;
constexpr double kRounding = 1e-9;  // [rad] rounding error accepted beyond the joint limits
constexpr double kFlat = 1e-6;      // damping of S relative to rod^2 where the rods lie in one plane [-]

struct Size {
  double base_radius, platform_radius, upper, rod;  // [m]
  double upper_mass, rod_mass, platform_mass;       // [kg]
};

Size read(Reader& reader) {
  return {reader.positive("base_radius", "radius of the hips' circle [m]"),
          reader.positive("platform_radius", "radius of the rods' circle on the platform [m]"),
          reader.positive("upper", "length of a driven arm [m]"),
          reader.positive("rod", "length of a rod [m]"),
          reader.positive("upper_mass", "mass of a driven arm [kg]"),
          reader.positive("rod_mass", "mass of the rods of one arm [kg]"),
          reader.positive("platform_mass", "mass of the platform with the handle [kg]")};
}

class Delta final : public Mechanism {
 public:
  explicit Delta(const Parameters& parameters) {
    Reader reader("delta", parameters);
    size_ = read(reader);
    facts_.tau_max = JointVector::Constant(kArms, reader.positive("torque_max", "largest torque of a drive [N m]"));
    facts_.v_max = JointVector::Constant(kArms, reader.number("speed_max", "largest speed of a joint [rad/s]", 10.0));
    facts_.q_min = JointVector::Constant(kArms, reader.number("q_min", "lower limit of the joints [rad]", -0.4));
    facts_.q_max = JointVector::Constant(kArms, reader.number("q_max", "upper limit of the joints [rad]", 1.2));
    reader.done();
    a_ = size_.base_radius - size_.platform_radius;
    reader.require(facts_.v_max[0] > 0.0, "speed_max must be above zero", "[rad/s]");
    reader.require(facts_.q_min[0] < facts_.q_max[0] && facts_.q_min[0] > -1.5 && facts_.q_max[0] < 1.5,
                   "q_min and q_max must rise and lie within -1.5 .. 1.5", "[rad]");
    reader.require(a_ + size_.upper * std::cos(std::max(std::abs(facts_.q_min[0]), facts_.q_max[0])) > 0.0,
                   "the elbows cross the middle", "make base_radius larger or platform_radius smaller");
    reader.require(size_.rod > a_ + size_.upper, "the rods are too short to be put together everywhere",
                   "rod must be longer than base_radius - platform_radius + upper");
    name_parts();
    m_elbow_ = 0.5 * size_.rod_mass;
    m_platform_ = size_.platform_mass + 3.0 * 0.5 * size_.rod_mass;
    inertia_ = (size_.upper_mass / 3.0 + m_elbow_) * size_.upper * size_.upper;
  }
  Delta(const Delta&) = default;
  [[nodiscard]] std::unique_ptr<Mechanism> clone() const override { return std::make_unique<Delta>(*this); }
  [[nodiscard]] const Facts& facts() const noexcept override { return facts_; }

  void kinematics(const JointVector& q, Pose& X_0T, Jacobian& J) noexcept override {
    solve(q);
    X_0T = {Mat3::Identity(), p_};
    J.resize(6, kArms);
    J.topRows<3>() = J_;
    J.bottomRows<3>().setZero();
  }

  void dynamics(const JointVector& q, const JointVector& v, Dynamics& d) noexcept override {
    kinematics(q, d.X_0T, d.J);
    // S p'' + S' p' = D q'' + D' q'
    const Vec3 velocity = J_ * v;
    Vec3 right;
    for (int i = 0; i < kArms; ++i) {
      const Vec3 s_dot = velocity - b_[i] * v[i];
      const Vec3 b_dot = size_.upper * v[i] * (-std::cos(q[i]) * u_[i] + std::sin(q[i]) * Vec3::UnitZ());
      right[i] = (s_dot.dot(b_[i]) + s_[i].dot(b_dot)) * v[i] - s_dot.dot(velocity);
    }
    const Vec3 drift = S_inverse_ * right;
    d.Jdot_v << drift, Vec3::Zero();
    d.M = m_platform_ * (J_.transpose() * J_);
    d.M.diagonal().array() += inertia_;
    d.G = -m_platform_ * (J_.transpose() * g_);
    for (int i = 0; i < kArms; ++i) d.G[i] -= (0.5 * size_.upper_mass + m_elbow_) * g_.dot(b_[i]);
    d.bias = d.G + m_platform_ * (J_.transpose() * drift);
  }

  [[nodiscard]] double potential_energy(const JointVector& q) noexcept override {
    solve(q);
    double P = -m_platform_ * g_.dot(p_);
    for (int i = 0; i < kArms; ++i) {
      P -= (0.5 * size_.upper_mass + m_elbow_) * g_.dot(elbow(q[i], i) - a_ * u_[i]);
    }
    return P;
  }

  void set_gravity(const Vec3& g_base) noexcept override { g_ = g_base; }

  void scale_masses(const JointVector& scale) override {  // the platform, which all motors carry, takes the mean
    const double mean = scale.mean();
    size_.upper_mass *= mean, m_elbow_ *= mean, m_platform_ *= mean, inertia_ *= mean;
  }

  bool closed_form(const Vec3& p, JointVector& q) const noexcept override {
    JointVector found = JointVector::Zero(kArms);
    const double L = size_.upper;
    for (int i = 0; i < kArms; ++i) {
      const double x = p.dot(u_[i]) - a_;
      const double C = (p.squaredNorm() - std::pow(p.dot(u_[i]), 2) + x * x + L * L - size_.rod * size_.rod) / (2 * L);
      const double reach = std::hypot(x, p.z());  // x cos q - z sin q = C
      if (!(std::abs(C) <= reach)) return false;
      found[i] = std::atan2(-p.z(), x) - std::acos(C / reach);
    }
    if ((found.array() < facts_.q_min.array() - kRounding).any()) return false;
    if ((found.array() > facts_.q_max.array() + kRounding).any()) return false;
    q = found;
    return true;
  }

  [[nodiscard]] Pose link_pose(int link) const noexcept override {  // base, upper1, rod1, ..., rod3, platform
    if (link == 0) return {};
    if (link > 2 * kArms) return {Mat3::Identity(), p_};
    const int i = (link - 1) / 2;
    const Vec3 hip = size_.base_radius * u_[i], knee = p_ - s_[i] + size_.platform_radius * u_[i];
    return link % 2 == 1 ? Pose{along(knee - hip), hip} : Pose{along(s_[i]), knee};
  }

 private:
  void name_parts() {
    facts_.orients = false;
    facts_.link_names = {"base"};
    for (int i = 0; i < kArms; ++i) {
      const double azimuth = 2.0 * std::numbers::pi * i / kArms;
      u_[i] = {std::cos(azimuth), std::sin(azimuth), 0.0};
      const std::string number = std::to_string(i + 1);
      facts_.joint_names.push_back("hip" + number);
      facts_.link_names.insert(facts_.link_names.end(), {"upper" + number, "rod" + number});
      facts_.segments.push_back({"base", size_.base_radius * u_[i]});
      facts_.segments.push_back({"upper" + number, size_.upper * Vec3::UnitZ()});
      facts_.segments.push_back({"rod" + number, size_.rod * Vec3::UnitZ()});
      facts_.segments.push_back({"platform", size_.platform_radius * u_[i]});
    }
    facts_.link_names.emplace_back("platform");
  }

  /// Position e_i of elbow i.
  [[nodiscard]] Vec3 elbow(double q, int i) const noexcept {
    return (a_ + size_.upper * std::cos(q)) * u_[i] - size_.upper * std::sin(q) * Vec3::UnitZ();
  }

  /// p, s_i, b_i and J at q.
  void solve(const JointVector& q) noexcept {
    std::array<Vec3, kArms> e;
    for (int i = 0; i < kArms; ++i) e[i] = elbow(q[i], i);
    // From the circumcentre of the elbows down along the normal of their plane.
    const Vec3 ab = e[1] - e[0], ac = e[2] - e[0];
    const Vec3 n = ab.cross(ac);  // points upwards, because the elbows are ordered counter-clockwise
    const Vec3 centre = (ac.squaredNorm() * n.cross(ab) + ab.squaredNorm() * ac.cross(n)) / (2.0 * n.squaredNorm());
    const double height = std::sqrt(std::max(size_.rod * size_.rod - centre.squaredNorm(), 0.0));
    p_ = e[0] + centre - height * n.normalized();

    Mat3 S;
    Vec3 D;
    for (int i = 0; i < kArms; ++i) {
      s_[i] = p_ - e[i];
      b_[i] = size_.upper * (-std::sin(q[i]) * u_[i] - std::cos(q[i]) * Vec3::UnitZ());
      S.row(i) = s_[i];
      D[i] = s_[i].dot(b_[i]);
    }
    // If the rods lie in one plane, S has no inverse. This is outside the joint limits, but must not divide by zero.
    const double rod2 = size_.rod * size_.rod;
    if (std::abs(S.determinant()) > kFlat * rod2 * size_.rod) {
      S_inverse_ = S.inverse();
    } else {
      Mat3 A = S.transpose() * S;
      A.diagonal().array() += kFlat * rod2;
      S_inverse_ = A.inverse();
      S_inverse_ *= S.transpose();
    }
    J_ = S_inverse_ * D.asDiagonal();
  }

  /// Axes whose z points along d.
  [[nodiscard]] static Mat3 along(const Vec3& d) noexcept {
    const Vec3 z = d.normalized(), side = std::abs(z.y()) < 0.9 ? Vec3::UnitY() : Vec3::UnitX();
    const Vec3 x = side.cross(z).normalized();
    Mat3 R;
    R << x, z.cross(x), z;
    return R;
  }

  Size size_{};
  Facts facts_;
  double a_ = 0.0, m_elbow_ = 0.0, m_platform_ = 0.0, inertia_ = 0.0;
  Vec3 g_{0.0, 0.0, -9.81};
  std::array<Vec3, kArms> u_, s_, b_;
  Vec3 p_ = Vec3::Zero();
  Mat3 J_ = Mat3::Zero(), S_inverse_ = Mat3::Zero();
};

}  // namespace

std::unique_ptr<Mechanism> make_delta(const Parameters& parameters) { return std::make_unique<Delta>(parameters); }

}  // namespace palpate::arm
