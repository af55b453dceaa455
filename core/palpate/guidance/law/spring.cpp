// Law `spring`: spring and damper towards the closest feasible pose:
//
//   F = max(K e - B gap', 0) J,    e = max(-gap, 0),    U = K e^2 / 2,    gap' the rate of the gap
#include "palpate/guidance/law/impedance.hpp"
#include "palpate/guidance/law/profile.hpp"

namespace palpate::guidance {
namespace {

class Spring final : public ImpedanceLaw {
 public:
  using ImpedanceLaw::ImpedanceLaw;

  [[nodiscard]] ConstraintForce force(const Constraint& c, const Twist& V_WT) const noexcept override {
    const double K = c.rotational ? o_.K_turn : o_.K, e = c.violation();
    ConstraintForce out =
        force_along(c, V_WT, K * e, K, c.rotational ? o_.B_turn : o_.B, std::numeric_limits<double>::infinity());
    out.U = 0.5 * K * e * e;
    return out;
  }
  [[nodiscard]] const char* name() const noexcept override { return "spring"; }
};

}  // namespace

std::shared_ptr<const Law> make_spring(const LawOptions& options) { return std::make_shared<Spring>(options); }

}  // namespace palpate::guidance
