#include "palpate/collision/paper_plane.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace palpate::collision {
namespace {

constexpr double kBaseline = 0.05;     // [r] smallest distance between kept points: noise of 1/20 tilts by 3 deg
constexpr double kCollinear = 0.2;     // ratio of the second to the first spread below which the points lie on a line
constexpr double kUndecided = 0.0872;  // cosine to x_n below which Eq 20 cannot choose a side (85 to 95 degrees)

}  // namespace

Vec3 grow_plane(std::span<const Vec3> points, const Vec3& n_last, double baseline) noexcept {
  if (points.size() < 3) return Vec3::Zero();
  const double n = static_cast<double>(points.size());
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : points) middle += p / n;
  Mat3 scatter = Mat3::Zero();
  for (const Vec3& p : points) scatter += (p - middle) * (p - middle).transpose() / n;

  const Eigen::SelfAdjointEigenSolver<Mat3> spread(scatter);  // eigenvalues: squared spreads, the smallest first
  const double first = std::sqrt(spread.eigenvalues()[2]), second = std::sqrt(spread.eigenvalues()[1]);
  if (!(2.0 * first >= baseline) || !(second >= kCollinear * first)) return Vec3::Zero();
  const Vec3 normal = spread.eigenvectors().col(0);
  const double side = normal.dot(n_last);
  if (std::abs(side) < kUndecided) return Vec3::Zero();
  return side < 0.0 ? Vec3(-normal) : normal;
}

void PaperPlane::free(const Vec3& /*v_OT*/) {
  n_.setZero();
  size_ = 0;
}

algorithm1::GrownPlane PaperPlane::touch(const Collision& c) {
  if (n_.isZero()) n_ = algorithm1::average_normal(c.points, n_);
  gather(c);
  const Vec3 grown = grow_plane({kept_.data(), static_cast<std::size_t>(size_)}, n_, kBaseline * c.radius);
  if (!grown.isZero()) n_ = grown;
  return algorithm1::through_deepest(c.points, n_, c.p_OT, c.radius);
}

/// Removes points that the sphere has left and adds new ones.
void PaperPlane::gather(const Collision& c) {
  const auto begin = kept_.begin();
  auto end = std::remove_if(begin, begin + size_, [&](const Vec3& p) { return (p - c.p_OT).norm() > c.radius; });
  for (int i = 0; i < c.points.size; ++i) {
    const Vec3& p = c.points.point[static_cast<std::size_t>(i)].p;
    if (std::any_of(begin, end, [&](const Vec3& q) { return (p - q).norm() < kBaseline * c.radius; })) continue;
    if (end == kept_.end()) end = std::move(begin + 1, end, begin);
    *end++ = p;
  }
  size_ = static_cast<int>(end - begin);
}

}  // namespace palpate::collision
