// A potential with a range and a largest force, F = -grad U (Khatib 1986 for the idea of it):
//
//   what attracts:  f(e) = min(K e, force), from 80 % of the range on falling to zero at the range; e = -gap
//   what repels:    f(e) = min(K e, force);  e = range - gap: felt before the border is reached
//
// piecewise straight, so that U = int f de is closed. K is no larger than what reaches `force` within the 80 %.
#include "palpate/guidance/law/profile.hpp"

namespace palpate::guidance {
namespace {

constexpr double kPlateau = 0.8;  // of the range, up to which an attraction does not fade

/// f and its integral U, of a deviation e.
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

class Potential final : public Law {
 public:
  explicit Potential(const LawOptions& options) : o_(options) {}

  [[nodiscard]] ConstraintForce force(const Constraint& c, const Twist& V_WT) const noexcept override {
    const double K = c.rotational ? o_.K_turn : o_.K, most = c.rotational ? o_.moment : o_.force;
    const double range = c.rotational ? o_.range_turn : o_.range;
    const bool there = c.gradient.f != Vec3::Zero() || c.rotational;
    const double e = c.attracts ? c.violation() : there ? range - c.gap : 0.0;
    const Profile at = profile(e, K, most, range, c.attracts);
    ConstraintForce out = force_along(c, V_WT, at.f, K, c.rotational ? o_.B_turn : o_.B, most);
    out.U = at.U;
    return out;
  }
  [[nodiscard]] const char* name() const noexcept override { return "potential"; }
  [[nodiscard]] double stiffness() const noexcept override { return o_.K; }
  [[nodiscard]] double damping() const noexcept override { return o_.B; }
  [[nodiscard]] double turning_stiffness() const noexcept override { return o_.K_turn; }
  [[nodiscard]] double turning_damping() const noexcept override { return o_.B_turn; }

 private:
  LawOptions o_;
};

}  // namespace

std::shared_ptr<const Law> make_potential(const LawOptions& options) { return std::make_shared<Potential>(options); }

}  // namespace palpate::guidance
