// Role `limit`: limits the tool's speed or the contact force inside the geometry, or, with neither limit, keeps the
// tool inside it (a workspace).
//
//   force:      gap = (force - |F|) / K + n . (p - p_touch),    n = F / |F|, K the stiffness of the touched environment
//   speed:      speed_limit = speed
//   workspace:  gap = margin - distance
#include "palpate/guidance/fixture.hpp"

namespace palpate::guidance {
namespace {

constexpr double kUnknownStiffness = 1000.0;  // [N/m] stiffness of the touched environment when it is unknown

class Limit final : public Role {
 public:
  explicit Limit(const RoleOptions& options) : margin_(options.margin), speed_(options.speed), force_(options.force) {}

  [[nodiscard]] Constraint constraint(const Query& query, const QueryDerivatives& /*derivatives*/,
                                      const ToolQuery& tool) const noexcept override {
    Constraint out;
    if (speed_ == 0.0 && force_ == 0.0) {
      out.gap = margin_ - query.distance;
      out.gradient.f = -query.gradient_norm * query.normal;
      out.set_fixture_motion(query, tool.X_WT.p);
      out.free = Mat3::Identity() - query.normal * query.normal.transpose();
      return out;
    }
    if (query.distance > margin_) return out;
    if (speed_ > 0.0) out.speed_limit = speed_;
    const double force = tool.F_T_W.norm();
    if (force_ > 0.0 && force > 0.0) {
      const Vec3 n = tool.F_T_W / force;
      out.gap = (force_ - force) / (tool.stiffness > 0.0 ? tool.stiffness : kUnknownStiffness) +
                n.dot(tool.X_WT.p - tool.p_touch);
      out.gradient.f = n;
      out.by_force = true;
      out.free = Mat3::Identity() - n * n.transpose();
    }
    return out;
  }
  [[nodiscard]] const char* name() const noexcept override { return "limit"; }
  [[nodiscard]] double border() const noexcept override { return margin_; }
  [[nodiscard]] bool needs_solid() const noexcept override { return margin_ == 0.0; }
  [[nodiscard]] bool has_gap() const noexcept override { return speed_ == 0.0 || force_ > 0.0; }

 private:
  double margin_, speed_, force_;
};

}  // namespace

std::shared_ptr<const Role> make_limit(const RoleOptions& options) { return std::make_shared<Limit>(options); }

}  // namespace palpate::guidance
