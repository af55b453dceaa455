// Role `rcm`: the shaft of the tool passes through a point, such as a trocar, where it may slide and turn.
//
//   gap = margin - |(1 - a a^T) (c - p_WT)|,    a the shaft's direction, c the point
#include "palpate/guidance/fixture.hpp"

namespace palpate::guidance {
namespace {

class Rcm final : public Role {
 public:
  explicit Rcm(const RoleOptions& options) : margin_(options.margin), axis_(options.axis.normalized()) {}

  [[nodiscard]] Constraint constraint(const Query& query, const QueryDerivatives& /*derivatives*/,
                                      const ToolQuery& tool) const noexcept override {
    const Vec3 a = tool.X_WT.R * axis_, to = query.point - tool.X_WT.p;
    const Vec3 lever = a * a.dot(to);  // from T to the point of the shaft nearest to c
    const Vec3 offset = to - lever;
    const double far = offset.norm();
    Constraint out;
    out.gap = margin_ - far;
    out.gradient.f = far > 0.0 ? Vec3(offset / far) : a.unitOrthogonal();
    out.gradient.t = lever.cross(out.gradient.f);
    out.set_fixture_motion(query, tool.X_WT.p);
    out.free = a * a.transpose();
    out.attracts = true;
    return out;
  }
  [[nodiscard]] const char* name() const noexcept override { return "rcm"; }
  [[nodiscard]] bool needs_point() const noexcept override { return true; }

 private:
  double margin_;
  Vec3 axis_;
};

}  // namespace

std::shared_ptr<const Role> make_rcm(const RoleOptions& options) { return std::make_shared<Rcm>(options); }

}  // namespace palpate::guidance
