// Inverse of a matrix over the joints. In plain loops, since Eigen's LU takes several seconds to compile.
#pragma once

#include <optional>

#include "palpate/types/spatial.hpp"

namespace palpate {

/// A^-1 by Gauss-Jordan elimination with row pivoting; nothing where A is not square or |det A| < 1e-9.
[[nodiscard]] std::optional<JointMatrix> inverse(JointMatrix A);

}  // namespace palpate
