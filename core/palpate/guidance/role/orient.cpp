// Role `orient`: aligns an axis of the tool with the geometry's axis or against its normal, or the whole tool with the
// geometry's frame.
//
//   gap = angle - w |theta|,    theta(R_WT, p_WT) the smallest rotation vector to the target attitude
//
// Along a curve or a curved surface the target direction changes with the position. The moment then comes with a force,
// because only both together are the gradient of the stored energy. The normal is the mean of the normals nearby
// (Geometry::normals), and w is its length. Where these normals disagree, the constraint is weaker, so that the target
// turns by at most 1 / kDifferenceStep.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "palpate/guidance/fixture.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::guidance {
namespace {

/// The smallest rotation vector that turns the unit vector a into b.
Vec3 turn(const Vec3& a, const Vec3& b) noexcept {
  const Vec3 side = a.cross(b);
  const double sine = side.norm(), angle = std::atan2(sine, a.dot(b));
  return sine > 1e-9 ? Vec3(angle / sine * side)
                     : Vec3(a.dot(b) > 0.0 ? side : Vec3(std::numbers::pi * a.unitOrthogonal()));
}

class Orient final : public Role {
 public:
  enum class Target { axis, normal, frame };
  Orient(const RoleOptions& options, Target target)
      : angle_(options.angle), axis_(options.axis.normalized()), target_(target) {}

  [[nodiscard]] Constraint constraint(const Query& query, const QueryDerivatives& derivatives,
                                      const ToolQuery& tool) const noexcept override {
    const Mat3& R = tool.X_WT.R;
    const Vec3 pointing = R * axis_;
    const double w = target_ == Target::normal ? derivatives.normal.norm() : 1.0;
    const Vec3 n = w > 0.0 ? Vec3(derivatives.normal / w) : Vec3(Vec3::Zero());
    const Vec3 theta = target_ == Target::frame    ? rotation_vector(query.attitude * R.transpose())
                       : target_ == Target::normal ? turn(pointing, Vec3(-n))
                                                   : turn(pointing, Vec3(query.attitude.col(2)));
    const double far = theta.norm();
    const Vec3 u = far > 0.0 ? Vec3(theta / far) : pointing.unitOrthogonal();
    Constraint out;
    out.rotational = true;
    out.attracts = true;
    out.gap = angle_ - w * far;
    out.gradient.t = w * u;
    // d|theta| = u . (n x dn) and dw = n . d_normal dp, with n = normal / w.
    out.gradient.f = target_ == Target::normal ? Vec3(-derivatives.d_normal.transpose() * (u.cross(n) + far * n))
                                               : Vec3(-derivatives.d_attitude.transpose() * u);
    out.set_fixture_motion(query, tool.X_WT.p);
    return out;
  }
  [[nodiscard]] bool needs_axis() const noexcept override { return target_ == Target::axis; }
  [[nodiscard]] const char* name() const noexcept override { return "orient"; }
  [[nodiscard]] Needs needs() const noexcept override {
    return target_ == Target::normal ? Needs::normals : Needs::attitude_derivative;
  }

 private:
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
