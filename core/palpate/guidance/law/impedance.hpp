// Base of the laws whose stiffness and damping are those of the options.
#pragma once

#include "palpate/guidance/fixture.hpp"

namespace palpate::guidance {

class ImpedanceLaw : public Law {
 public:
  explicit ImpedanceLaw(const LawOptions& options) : o_(options) {}

  [[nodiscard]] double stiffness() const noexcept override { return o_.K; }
  [[nodiscard]] double damping() const noexcept override { return o_.B; }
  [[nodiscard]] double turning_stiffness() const noexcept override { return o_.K_turn; }
  [[nodiscard]] double turning_damping() const noexcept override { return o_.B_turn; }

 protected:
  LawOptions o_;
};

}  // namespace palpate::guidance
