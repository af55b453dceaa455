// The tool stays inside the geometry, by a margin.
//
//   gap = -distance - margin
#include "palpate/guidance/fixture.hpp"

namespace palpate::guidance {
namespace {

class KeepIn final : public Role {
 public:
  explicit KeepIn(const RoleOptions& options) : margin_(options.margin) {}

  [[nodiscard]] Want want(const Query& query, const Around& /*around*/, const Tool& tool) const noexcept override {
    Want out;
    out.gap = -query.distance - margin_;
    out.along.f = -query.steep * query.normal;
    out.carried_by(query, tool.X_WT.p);
    out.free = Mat3::Identity() - query.normal * query.normal.transpose();
    return out;
  }
  [[nodiscard]] const char* name() const noexcept override { return "keep-in"; }
  [[nodiscard]] bool needs_solid() const noexcept override { return true; }

 private:
  double margin_;
};

}  // namespace

std::shared_ptr<const Role> make_keep_in(const RoleOptions& options) { return std::make_shared<KeepIn>(options); }

}  // namespace palpate::guidance
