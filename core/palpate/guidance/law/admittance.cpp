// Anisotropic admittance (Bettini, Marayong, Lang, Okamura, Hager 2004): under the same force the tool moves `ratio`
// times as fast across what is wanted as along it,
//
//   v = (P + ratio (1 - P)) f / B          P projects on the free directions
//
// rendered as the damping it is, F = -B (P + (1 - P) / ratio) v. A motion that mends the deviation is free as well; a
// role that repels slows the approach alone, within `range` of the border. Damping whatever happens: nothing is stored.
#include "palpate/guidance/law/profile.hpp"

namespace palpate::guidance {
namespace {

class Admittance final : public Law {
 public:
  explicit Admittance(const LawOptions& options) : o_(options) {}

  [[nodiscard]] Pull pull(const Want& want, const Twist& V_WT) const noexcept override {
    return want.turns ? turning(want, V_WT) : want.attracts ? attracting(want, V_WT) : repelling(want, V_WT);
  }
  [[nodiscard]] const char* name() const noexcept override { return "admittance"; }
  [[nodiscard]] double stiffness() const noexcept override { return 0.0; }
  [[nodiscard]] double damping() const noexcept override { return o_.B / o_.ratio; }
  [[nodiscard]] double turning_stiffness() const noexcept override { return 0.0; }
  [[nodiscard]] double turning_damping() const noexcept override { return o_.B_turn / o_.ratio; }

 private:
  [[nodiscard]] Pull turning(const Want& want, const Twist& V_WT) const noexcept {
    Pull out;
    const double worse = std::min(want.rate(V_WT), 0.0), share = std::min(want.wrong() / kComesInTurn, 1.0);
    out.F.t = -o_.B_turn * V_WT.w - share * (o_.B_turn / o_.ratio - o_.B_turn) * worse * want.along.t;
    return out;
  }

  [[nodiscard]] Pull attracting(const Want& want, const Twist& V_WT) const noexcept {
    Pull out;
    const double more = o_.B / o_.ratio - o_.B;
    const Mat3 hard = Mat3::Identity() - want.free;
    const Vec3 n = (hard * want.along.f).stableNormalized();
    const double mends = want.rate(V_WT) > 0.0 ? std::min(want.wrong() / kComesIn, 1.0) : 0.0;
    const bool levers = want.along.t != Vec3::Zero();
    out.B = o_.B * Mat3::Identity() + more * (hard - (levers ? 1.0 : mends) * n * n.transpose());
    out.F_of_B.f = out.F.f = -out.B * V_WT.v;
    // What the tool's turning changes, too, is damped as one: of place alone it would be a step where the rate turns.
    const double rate = want.along.f.dot(V_WT.v) + want.along.t.dot(V_WT.w);
    const double f = levers ? more * (1.0 - mends) * rate : 0.0;
    out.F = {out.F.f - f * want.along.f, -f * want.along.t};
    return out;
  }

  [[nodiscard]] Pull repelling(const Want& want, const Twist& V_WT) const noexcept {
    Pull out;
    const Vec3 n = want.along.f.stableNormalized();
    const double near = std::clamp(1.0 - want.gap / o_.range, 0.0, 1.0), rate = want.rate(V_WT);
    out.B = o_.B * near * Mat3::Identity();
    if (rate < 0.0) out.B += o_.B * (1.0 / o_.ratio - 1.0) * near * n * n.transpose();
    out.F_of_B.f = out.F.f = -out.B * (V_WT.v + want.drift * n);
    return out;
  }

  LawOptions o_;
};

}  // namespace

std::shared_ptr<const Law> make_admittance(const LawOptions& options) { return std::make_shared<Admittance>(options); }

}  // namespace palpate::guidance
