// Role `keep-in`: the tool stays inside the geometry, at least by a margin.
//
//   gap = -distance - margin
#include "palpate/guidance/fixture.hpp"

namespace palpate::guidance {
namespace {

class KeepIn final : public Role {
 public:
  explicit KeepIn(const RoleOptions& options) : margin_(options.margin) {}

  [[nodiscard]] Constraint constraint(const Query& query, const QueryDerivatives& /*derivatives*/,
                                      const ToolQuery& tool) const noexcept override {
    Constraint out;
    out.gap = -query.distance - margin_;
    out.gradient.f = -query.gradient_norm * query.normal;
    out.set_fixture_motion(query, tool.X_WT.p);
    out.free = Mat3::Identity() - query.normal * query.normal.transpose();
    return out;
  }
  [[nodiscard]] const char* name() const noexcept override { return "keep-in"; }
  [[nodiscard]] double border() const noexcept override { return margin_; }
  [[nodiscard]] bool needs_solid() const noexcept override { return true; }

 private:
  double margin_;
};

}  // namespace

std::shared_ptr<const Role> make_keep_in(const RoleOptions& options) { return std::make_shared<KeepIn>(options); }

}  // namespace palpate::guidance
