// Law `spring`: spring and damper towards the closest feasible pose:
//
//   F = max(K e - B gap', 0) J,    e = max(-gap, 0),    U = K e^2 / 2,    gap' the rate of the gap
#include "palpate/guidance/law/profile.hpp"

namespace palpate::guidance {
namespace {

class Spring final : public Law {
 public:
  explicit Spring(const LawOptions& options) : o_(options) {}

  [[nodiscard]] ConstraintForce force(const Constraint& c, const Twist& V_WT) const noexcept override {
    const double K = c.rotational ? o_.K_turn : o_.K, e = c.violation();
    ConstraintForce out =
        force_along(c, V_WT, K * e, K, c.rotational ? o_.B_turn : o_.B, std::numeric_limits<double>::infinity());
    out.U = 0.5 * K * e * e;
    return out;
  }
  [[nodiscard]] const char* name() const noexcept override { return "spring"; }
  [[nodiscard]] double stiffness() const noexcept override { return o_.K; }
  [[nodiscard]] double damping() const noexcept override { return o_.B; }
  [[nodiscard]] double turning_stiffness() const noexcept override { return o_.K_turn; }
  [[nodiscard]] double turning_damping() const noexcept override { return o_.B_turn; }

 private:
  LawOptions o_;
};

}  // namespace

std::shared_ptr<const Law> make_spring(const LawOptions& options) { return std::make_shared<Spring>(options); }

}  // namespace palpate::guidance
