// Checks of options during construction. They throw, and therefore must not be used in a cycle.
#pragma once

#include <stdexcept>
#include <string>

namespace palpate {

/// Throws std::invalid_argument with the text "OWNER.KEY = VALUE: REMEDY" unless `good`. The owner is the stage that
/// reads the option, for example "torque"; the remedy says which values are allowed.
inline void require(const std::string& owner, bool good, const char* key, double value, const char* remedy) {
  if (!good) throw std::invalid_argument(owner + "." + key + " = " + std::to_string(value) + ": " + remedy);
}

}  // namespace palpate
