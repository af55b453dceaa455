// Role `guide`: attracts the tool to a point, a line, a path or a surface, along which it moves freely.
//
//   gap = margin - |distance|
#include <cmath>

#include "palpate/guidance/fixture.hpp"

namespace palpate::guidance {
namespace {

class Guide final : public Role {
 public:
  explicit Guide(const RoleOptions& options) : margin_(options.margin) {}

  [[nodiscard]] Constraint constraint(const Query& query, const QueryDerivatives& /*derivatives*/,
                                      const ToolQuery& tool) const noexcept override {
    Constraint out;
    const double side = query.distance < 0.0 ? -1.0 : 1.0;
    out.gap = margin_ - std::abs(query.distance);
    out.gradient.f = -side * query.gradient_norm * query.normal;
    out.set_fixture_motion(query, tool.X_WT.p);
    const auto tangents = query.basis.leftCols(query.dimension);
    out.free = tangents * tangents.transpose();
    out.attracts = true;
    return out;
  }
  [[nodiscard]] const char* name() const noexcept override { return "guide"; }

 private:
  double margin_;
};

}  // namespace

std::shared_ptr<const Role> make_guide(const RoleOptions& options) { return std::make_shared<Guide>(options); }

}  // namespace palpate::guidance
