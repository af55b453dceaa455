#include "palpate/plant/depth_image.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

namespace palpate::plant {
namespace {

constexpr int kLargest = 4096;     // [pixel]
constexpr double kOnEdge = -1e-9;  // barycentric coordinate that still counts as inside: neighbours leave no gap
constexpr double kSlack = 1e-3;    // [pixel] kept beyond an edge, whose pixels are tested one by one
constexpr int kNarrow = 8;         // width up to which all pixels of the bounding box are tested [pixel]
constexpr double kFlat = 1e-12;    // doubled area of a triangle that is seen edge-on [pixel^2]

/// Range of pixels of a row, relative to the bounding box.
struct Span {
  double first, last;

  /// Keeps the part in which at_first + slope * pixel is not negative.
  void keep(double at_first, double slope) noexcept {
    const double zero = -at_first / slope;
    if (slope > 0.0)
      first = std::max(first, zero - kSlack);
    else if (slope < 0.0)
      last = std::min(last, zero + kSlack);
    else if (at_first < kOnEdge)
      last = -1.0;
  }
};

}  // namespace

DepthImage::DepthImage(const Pinhole& lens) : lens_(lens) {
  if (lens.columns < 1 || lens.rows < 1 || lens.columns > kLargest || lens.rows > kLargest)
    throw std::invalid_argument("the image must have 1 to 4096 columns and rows");
  if (!(lens.fx > 0.0) || !(lens.fy > 0.0) || !(lens.near > 0.0) || !std::isfinite(lens.cx + lens.cy))
    throw std::invalid_argument("focal lengths and the nearest depth must be positive, the principal point finite");
  const std::size_t n = static_cast<std::size_t>(lens.columns) * static_cast<std::size_t>(lens.rows);
  inverse_depth_.resize(n);
  plane_.resize(n);
  object_.resize(n);
  clear();
}

void DepthImage::clear() noexcept {
  std::ranges::fill(inverse_depth_, 0.0F);
  std::ranges::fill(plane_, 0.0F);
  std::ranges::fill(object_, std::int16_t{-1});
}

DepthImage::Corner DepthImage::project(const Vec3& p_C) const noexcept {
  const double w = 1.0 / p_C.z();
  return {lens_.fx * p_C.x() * w + lens_.cx, lens_.fy * p_C.y() * w + lens_.cy, w};
}

void DepthImage::draw(std::span<const double> vertices_O, std::span<const std::int32_t> triangles, const Pose& X_CO,
                      std::int16_t id) {
  const std::size_t n = vertices_O.size() / 3;
  corners_C_.resize(n);
  corners_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    corners_C_[i] = X_CO.R * Vec3::Map(vertices_O.data() + 3 * i) + X_CO.p;
    if (corners_C_[i].z() >= lens_.near) corners_[i] = project(corners_C_[i]);
  }
  for (std::size_t k = 0; k + 2 < triangles.size(); k += 3) {
    const auto [i, j, l] =
        std::tuple{static_cast<std::size_t>(triangles[k]), static_cast<std::size_t>(triangles[k + 1]),
                   static_cast<std::size_t>(triangles[k + 2])};
    const Vec3 &a = corners_C_[i], &b = corners_C_[j], &c = corners_C_[l];
    const int behind = (a.z() < lens_.near) + (b.z() < lens_.near) + (c.z() < lens_.near);
    if (behind == 0) {
      const Vec3 normal = (b - a).cross(c - a);
      const double length = normal.norm();
      const double plane = length > 0.0 ? std::abs(normal.dot(a)) / length : 0.0;
      fill(corners_[i], corners_[j], corners_[l], static_cast<float>(plane), id);
    } else if (behind < 3) {
      clip(a, b, c, id);
    }
  }
}

void DepthImage::clip(const Vec3& a, const Vec3& b, const Vec3& c, std::int16_t id) noexcept {
  const Vec3* const corner[3] = {&a, &b, &c};
  Vec3 kept[4];
  int n = 0;
  for (int i = 0; i < 3; ++i) {
    const Vec3 &p = *corner[i], &q = *corner[(i + 1) % 3];
    if (p.z() >= lens_.near) kept[n++] = p;
    if ((p.z() >= lens_.near) != (q.z() >= lens_.near))
      kept[n++] = p + (lens_.near - p.z()) / (q.z() - p.z()) * (q - p);
  }
  const Vec3 normal = (b - a).cross(c - a);
  const double length = normal.norm();
  const double plane = length > 0.0 ? std::abs(normal.dot(a)) / length : 0.0;
  for (int i = 2; i < n; ++i)
    fill(project(kept[0]), project(kept[i - 1]), project(kept[i]), static_cast<float>(plane), id);
}

void DepthImage::fill(const Corner& a, const Corner& b, const Corner& c, float plane, std::int16_t id) noexcept {
  const auto first = [](double low, int) { return std::max(0, static_cast<int>(std::ceil(std::max(low, -1.0)))); };
  const auto last = [](double high, int size) {
    return std::min(size - 1, static_cast<int>(std::floor(std::min(high, static_cast<double>(size)))));
  };
  const int u0 = first(std::min({a.u, b.u, c.u}), 0), u1 = last(std::max({a.u, b.u, c.u}), lens_.columns);
  const int v0 = first(std::min({a.v, b.v, c.v}), 0), v1 = last(std::max({a.v, b.v, c.v}), lens_.rows);
  if (u0 > u1 || v0 > v1) return;
  const double area = (b.u - a.u) * (c.v - a.v) - (c.u - a.u) * (b.v - a.v);
  if (!(std::abs(area) > kFlat)) return;
  const double s = 1.0 / area;
  // Barycentric coordinates of b and c at a pixel: linear in u and v.
  const double beta_u = (c.v - a.v) * s, beta_v = -(c.u - a.u) * s;
  const double gamma_u = -(b.v - a.v) * s, gamma_v = (b.u - a.u) * s;
  const double w_u = beta_u * (b.w - a.w) + gamma_u * (c.w - a.w);
  const bool is_wide = u1 - u0 > kNarrow;
  for (int v = v0; v <= v1; ++v) {
    const double beta0 = beta_u * (u0 - a.u) + beta_v * (v - a.v), gamma0 = gamma_u * (u0 - a.u) + gamma_v * (v - a.v);
    Span span{0.0, static_cast<double>(u1 - u0)};
    if (is_wide) {  // a long thin triangle covers a small part of its bounding box
      span.keep(beta0, beta_u);
      span.keep(gamma0, gamma_u);
      span.keep(1.0 - beta0 - gamma0, -beta_u - gamma_u);
      if (!(span.first <= span.last)) continue;
    }
    const int first_u = std::max(0, static_cast<int>(span.first)),
              last_u = std::min(u1 - u0, static_cast<int>(span.last) + 1);
    double beta = beta0 + first_u * beta_u, gamma = gamma0 + first_u * gamma_u;
    double w = a.w + beta * (b.w - a.w) + gamma * (c.w - a.w);
    std::size_t i =
        static_cast<std::size_t>(v) * static_cast<std::size_t>(lens_.columns) + static_cast<std::size_t>(u0 + first_u);
    for (int u = first_u; u <= last_u; ++u, ++i, beta += beta_u, gamma += gamma_u, w += w_u) {
      if (beta < kOnEdge || gamma < kOnEdge || beta + gamma > 1.0 - kOnEdge) continue;
      if (const float near = static_cast<float>(w); near > inverse_depth_[i]) {
        inverse_depth_[i] = near;
        plane_[i] = plane;
        object_[i] = id;
      }
    }
  }
}

std::vector<float> DepthImage::cosine() const {
  std::vector<float> found(inverse_depth_.size());
  std::size_t i = 0;
  for (int v = 0; v < lens_.rows; ++v) {
    const double y = (v - lens_.cy) / lens_.fy;
    for (int u = 0; u < lens_.columns; ++u, ++i) {
      const double x = (u - lens_.cx) / lens_.fx;
      // The plane n . p = c holds at p = z (x, y, 1), so n . (x, y, 1) = c / z.
      found[i] = plane_[i] * inverse_depth_[i] / static_cast<float>(std::sqrt(x * x + y * y + 1.0));
    }
  }
  return found;
}

}  // namespace palpate::plant
