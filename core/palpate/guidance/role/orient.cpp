// Turns the tool: its axis along the geometry's axis, against its normal, or the whole tool as the geometry's frame is.
//
//   gap = angle - |theta|,    theta(R_WT, p_WT) the smallest rotation vector that turns the tool as it is wanted
//
// Along a curve or a bent surface the aim turns with the place: then a force belongs to the moment, and only the two
// together are the gradient of what is stored.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "palpate/guidance/fixture.hpp"

namespace palpate::guidance {
namespace {

/// The smallest rotation vector that turns the unit vector a into b.
Vec3 turn(const Vec3& a, const Vec3& b) noexcept {
  const Vec3 side = a.cross(b);
  const double sine = side.norm(), angle = std::atan2(sine, a.dot(b));
  return sine > 1e-9 ? Vec3(angle / sine * side)
                     : Vec3(a.dot(b) > 0.0 ? side : Vec3(std::numbers::pi * a.unitOrthogonal()));
}

/// The rotation vector of R.
Vec3 turn(const Mat3& R) noexcept {
  const Eigen::AngleAxisd rotation(R);
  return rotation.angle() * rotation.axis();
}

class Orient final : public Role {
 public:
  enum class Target { axis, normal, frame };
  Orient(const RoleOptions& options, Target target)
      : angle_(options.angle), axis_(options.axis.normalized()), target_(target) {}

  [[nodiscard]] Want want(const Query& query, const Slope& slope, const Tool& tool) const noexcept override {
    const Mat3& R = tool.X_WT.R;
    const Vec3 pointing = R * axis_;
    const Vec3 theta = target_ == Target::frame    ? turn(Mat3(query.attitude * R.transpose()))
                       : target_ == Target::normal ? turn(pointing, Vec3(-query.normal))
                                                   : turn(pointing, Vec3(query.attitude.col(2)));
    const double far = theta.norm();
    Want out;
    out.turns = true;
    out.attracts = true;
    out.gap = angle_ - far;
    out.along.t = far > 0.0 ? Vec3(theta / far) : pointing.unitOrthogonal();
    out.along.f = -turn_of_aim(query, slope).transpose() * out.along.t;
    out.carried_by(query, tool.X_WT.p);
    return out;
  }
  [[nodiscard]] bool needs_axis() const noexcept override { return target_ == Target::axis; }
  [[nodiscard]] const char* name() const noexcept override { return "orient"; }
  [[nodiscard]] bool needs_slope() const noexcept override { return true; }

 private:
  /// By which the aim turns when the tool is shifted [rad/m].
  [[nodiscard]] Mat3 turn_of_aim(const Query& query, const Slope& slope) const noexcept {
    if (target_ != Target::normal) return slope.turn;
    Mat3 out;  // n x dn
    for (Eigen::Index k = 0; k < 3; ++k) out.col(k) = query.normal.cross(Vec3(slope.normal.col(k)));
    return out;
  }

  double angle_;
  Vec3 axis_;
  Target target_;
};

}  // namespace

std::shared_ptr<const Role> make_orient(const RoleOptions& options) {
  const auto with = [&](Orient::Target target) { return std::make_shared<Orient>(options, target); };
  if (options.target == "axis") return with(Orient::Target::axis);
  if (options.target == "normal") return with(Orient::Target::normal);
  if (options.target == "frame") return with(Orient::Target::frame);
  throw std::invalid_argument("role.target = '" + options.target + "': must be axis, normal or frame");
}

}  // namespace palpate::guidance
