// Law `optimise`: a force towards the nearest pose that satisfies all fixtures with this law together. The corrector
// finds that pose (corrector.hpp); e is the share of this fixture in the correction:
//
//   F = clamp(min(K e, force) - B gap', 0, force) J,    gap' the rate of the gap
#include "palpate/guidance/law/impedance.hpp"
#include "palpate/guidance/law/profile.hpp"

namespace palpate::guidance {
namespace {

class Optimise final : public ImpedanceLaw {
 public:
  using ImpedanceLaw::ImpedanceLaw;

  [[nodiscard]] ConstraintForce force(const Constraint& c, const Twist& V_WT) const noexcept override {
    const double K = c.rotational ? o_.K_turn : o_.K, most = this->most(c);
    const double e = c.violation(), knee = K > 0.0 ? most / K : 0.0;
    ConstraintForce out = force_along(c, V_WT, std::min(K * e, most), K, c.rotational ? o_.B_turn : o_.B, most);
    out.U = e < knee ? 0.5 * K * e * e : most * (e - 0.5 * knee);
    return out;
  }
  [[nodiscard]] const char* name() const noexcept override { return "optimise"; }
  [[nodiscard]] double most(const Constraint& c) const noexcept override { return c.rotational ? o_.moment : o_.force; }
  [[nodiscard]] bool solves_jointly() const noexcept override { return true; }
};

}  // namespace

std::shared_ptr<const Law> make_optimise(const LawOptions& options) { return std::make_shared<Optimise>(options); }

}  // namespace palpate::guidance
