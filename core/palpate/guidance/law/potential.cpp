// Law `potential`: a potential field with a range and a largest force, F = -grad U (after Khatib 1986):
//
//   attraction:  f(e) = min(K e, force),  e = -gap;  falls linearly to zero between 80 % and 100 % of the range
//   repulsion:   f(e) = min(K e, force),  e = range - gap, so that it acts before the border is reached
//
// f is piecewise linear, so U = int f de has a closed form. An attraction never exceeds K times 80 % of the range.
#include "palpate/guidance/law/impedance.hpp"
#include "palpate/guidance/law/profile.hpp"

namespace palpate::guidance {
namespace {

constexpr double kPlateau = 0.8;  // fraction of the range at which an attraction begins to fade

/// f [N, N m] and its integral U [J] at a deviation e [m, rad].
struct Profile {
  double f = 0.0, U = 0.0;
};

Profile profile(double e, double K, double most, double range, bool fades) noexcept {
  if (!(e > 0.0) || K <= 0.0) return {};
  const double fade_at = kPlateau * range;
  const double top = fades ? std::min(most, K * fade_at) : most;
  const double knee = top / K;
  if (e <= knee) return {K * e, 0.5 * K * e * e};
  const double to_knee = 0.5 * K * knee * knee;
  if (!fades || e <= fade_at) return {top, to_knee + top * (e - knee)};
  const double width = range - fade_at, into = std::min(e - fade_at, width);
  return {top * (1.0 - into / width), to_knee + top * (fade_at - knee + into - 0.5 * into * into / width)};
}

class Potential final : public ImpedanceLaw {
 public:
  using ImpedanceLaw::ImpedanceLaw;

  [[nodiscard]] ConstraintForce force(const Constraint& c, const Twist& V_WT) const noexcept override {
    const double K = c.rotational ? o_.K_turn : o_.K, most = this->most(c);
    const double range = c.rotational ? o_.range_turn : o_.range;
    const bool there = c.gradient.f != Vec3::Zero() || c.rotational;
    const double e = c.attracts ? c.violation() : there ? range - c.gap : 0.0;
    const Profile at = profile(e, K, most, range, c.attracts);
    ConstraintForce out = force_along(c, V_WT, at.f, K, c.rotational ? o_.B_turn : o_.B, most);
    out.U = at.U;
    return out;
  }
  [[nodiscard]] const char* name() const noexcept override { return "potential"; }
  [[nodiscard]] double most(const Constraint& c) const noexcept override { return c.rotational ? o_.moment : o_.force; }
  [[nodiscard]] double reach() const noexcept override { return o_.range; }
};

}  // namespace

std::shared_ptr<const Law> make_potential(const LawOptions& options) { return std::make_shared<Potential>(options); }

}  // namespace palpate::guidance
