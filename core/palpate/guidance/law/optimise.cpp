// Pulls to the nearest place that is as all such fixtures want it at once (guidance.cpp asks the quadratic program for
// it; this fixture's share of the way there is its multiplier):
//
//   F = min(K e - B gap', force) along
#include "palpate/guidance/law/profile.hpp"

namespace palpate::guidance {
namespace {

class Optimise final : public Law {
 public:
  explicit Optimise(const LawOptions& options) : o_(options) {}

  [[nodiscard]] Pull pull(const Want& want, const Twist& V_WT) const noexcept override {
    const double K = want.turns ? o_.K_turn : o_.K, most = want.turns ? o_.moment : o_.force;
    const double e = want.wrong(), knee = K > 0.0 ? most / K : 0.0;
    Pull out = along(want, V_WT, std::min(K * e, most), K, want.turns ? o_.B_turn : o_.B, most);
    out.U = e < knee ? 0.5 * K * e * e : most * (e - 0.5 * knee);
    return out;
  }
  [[nodiscard]] const char* name() const noexcept override { return "optimise"; }
  [[nodiscard]] double stiffness() const noexcept override { return o_.K; }
  [[nodiscard]] double damping() const noexcept override { return o_.B; }
  [[nodiscard]] double turning_stiffness() const noexcept override { return o_.K_turn; }
  [[nodiscard]] double turning_damping() const noexcept override { return o_.B_turn; }
  [[nodiscard]] bool jointly() const noexcept override { return true; }

 private:
  LawOptions o_;
};

}  // namespace

std::shared_ptr<const Law> make_optimise(const LawOptions& options) { return std::make_shared<Optimise>(options); }

}  // namespace palpate::guidance
