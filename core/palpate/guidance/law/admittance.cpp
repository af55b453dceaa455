// Law `admittance`: anisotropic admittance (Bettini, Marayong, Lang, Okamura, Hager 2004). Under the same force the
// tool moves `ratio` times as fast across the free directions as along them:
//
//   v = (P + ratio (1 - P)) f / B          P projects onto the free directions
//
// It is rendered as damping, F = -B (P + (1 - P) / ratio) v. A motion that reduces the violation counts as free. For a
// repelling role the damping rises within `range` of the border, and only the approach is damped more. The law stores
// no energy.
#include "palpate/guidance/law/profile.hpp"

namespace palpate::guidance {
namespace {

class Admittance final : public Law {
 public:
  explicit Admittance(const LawOptions& options) : o_(options) {}

  [[nodiscard]] ConstraintForce force(const Constraint& c, const Twist& V_WT) const noexcept override {
    return c.rotational ? turning(c, V_WT) : c.attracts ? attracting(c, V_WT) : repelling(c, V_WT);
  }
  [[nodiscard]] const char* name() const noexcept override { return "admittance"; }
  [[nodiscard]] double stiffness() const noexcept override { return 0.0; }
  [[nodiscard]] double reach() const noexcept override { return o_.range; }
  [[nodiscard]] double damping() const noexcept override { return o_.B / o_.ratio; }
  [[nodiscard]] double turning_stiffness() const noexcept override { return 0.0; }
  [[nodiscard]] double turning_damping() const noexcept override { return o_.B_turn / o_.ratio; }

 private:
  [[nodiscard]] ConstraintForce turning(const Constraint& c, const Twist& V_WT) const noexcept {
    ConstraintForce out;
    const double approach_rate = std::min(c.rate(V_WT), 0.0),
                 share = std::min(c.violation() / kDampingRampRotational, 1.0);
    out.F.t = -o_.B_turn * V_WT.w - share * (o_.B_turn / o_.ratio - o_.B_turn) * approach_rate * c.gradient.t;
    return out;
  }

  [[nodiscard]] ConstraintForce attracting(const Constraint& c, const Twist& V_WT) const noexcept {
    ConstraintForce out;
    const double more = o_.B / o_.ratio - o_.B;
    const Mat3 hard = Mat3::Identity() - c.free;
    const Vec3 n = (hard * c.gradient.f).stableNormalized();
    const double recovery = c.rate(V_WT) > 0.0 ? std::min(c.violation() / kDampingRamp, 1.0) : 0.0;
    const bool depends_on_rotation = c.gradient.t != Vec3::Zero();
    out.B = o_.B * Mat3::Identity() + more * (hard - (depends_on_rotation ? 1.0 : recovery) * n * n.transpose());
    out.F_of_B.f = out.F.f = -out.B * V_WT.v;
    // A gap that also depends on rotation (rcm) is damped along its whole gradient: damping of the translation alone
    // would step where the rate changes its sign.
    const double rate = c.gradient.f.dot(V_WT.v) + c.gradient.t.dot(V_WT.w);
    const double f = depends_on_rotation ? more * (1.0 - recovery) * rate : 0.0;
    out.F = {out.F.f - f * c.gradient.f, -f * c.gradient.t};
    return out;
  }

  [[nodiscard]] ConstraintForce repelling(const Constraint& c, const Twist& V_WT) const noexcept {
    ConstraintForce out;
    const Vec3 n = c.gradient.f.stableNormalized();
    const double near = std::clamp(1.0 - c.gap / o_.range, 0.0, 1.0), rate = c.rate(V_WT);
    out.B = o_.B * near * Mat3::Identity();
    if (rate < 0.0) out.B += o_.B * (1.0 / o_.ratio - 1.0) * near * n * n.transpose();
    out.F_of_B.f = out.F.f = -out.B * (V_WT.v + c.gap_rate_of_fixture * n);
    return out;
  }

  LawOptions o_;
};

}  // namespace

std::shared_ptr<const Law> make_admittance(const LawOptions& options) { return std::make_shared<Admittance>(options); }

}  // namespace palpate::guidance
