// Checks of options while something is built: they throw, so they do not belong in a cycle.
#pragma once

#include <stdexcept>
#include <string>

namespace palpate {

/// Throws std::invalid_argument "OWNER.KEY = VALUE: MEND" unless `good`; owner: for example the stage "torque".
inline void require(const std::string& owner, bool good, const char* key, double value, const char* mend) {
  if (!good) throw std::invalid_argument(owner + "." + key + " = " + std::to_string(value) + ": " + mend);
}

}  // namespace palpate
