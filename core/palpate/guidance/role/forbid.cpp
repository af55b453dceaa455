// Role `forbid`: the tool stays outside the geometry and a margin around it. Around a point, a line or a path the
// margin alone is forbidden.
//
//   gap = distance - margin
#include "palpate/guidance/fixture.hpp"

namespace palpate::guidance {
namespace {

class Forbid final : public Role {
 public:
  explicit Forbid(const RoleOptions& options) : margin_(options.margin) {}

  [[nodiscard]] Constraint constraint(const Query& query, const QueryDerivatives& /*derivatives*/,
                                      const ToolQuery& tool) const noexcept override {
    Constraint out;
    out.gap = query.distance - margin_;
    out.gradient.f = query.gradient_norm * query.normal;
    out.set_fixture_motion(query, tool.X_WT.p);
    out.free = Mat3::Identity() - query.normal * query.normal.transpose();
    return out;
  }
  [[nodiscard]] const char* name() const noexcept override { return "forbid"; }
  [[nodiscard]] double border() const noexcept override { return margin_; }
  [[nodiscard]] bool needs_solid() const noexcept override { return margin_ == 0.0; }

 private:
  double margin_;
};

}  // namespace

std::shared_ptr<const Role> make_forbid(const RoleOptions& options) { return std::make_shared<Forbid>(options); }

}  // namespace palpate::guidance
