// Queries of random meshes against the minimum over all triangles, and damaged images of meshes.
#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/scene/mesh_impl.hpp"
#include "soup.hpp"

namespace {

using fuzz::require;
using palpate::Vec3;
using palpate::scene::Mesh;

/// Distance to the nearest triangle, without the hierarchy [m].
double brute_force(const Mesh& mesh, const Vec3& p) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    least = std::min(least, mesh.impl().closest_on(static_cast<std::int32_t>(t), p).distance2);
  }
  return std::sqrt(least);
}

void query(const Mesh& mesh, fuzz::Bytes& bytes, double size) {
  const Vec3 p = bytes.vector(2.0 * size), q = bytes.vector(2.0 * size);
  const double within = std::abs(bytes.number(size)), radius = 1e-3 * size + std::abs(bytes.number(0.1 * size));
  if (!p.allFinite() || !q.allFinite() || !std::isfinite(within) || !std::isfinite(radius)) {
    (void)mesh.closest(p, std::numeric_limits<double>::infinity());
    return;
  }
  if (std::max({p.norm(), q.norm(), within, radius}) > 1e3) {  // too far for the tolerances below
    (void)mesh.closest(p, std::numeric_limits<double>::infinity());
    (void)mesh.sweep(p, q, radius);
    return;
  }
  const double extent = (mesh.report().highest - mesh.report().lowest).norm() + mesh.report().highest.norm();
  const double truth = brute_force(mesh, p), error = 1e-9 * truth + 1e-11 * (extent + p.norm());
  const palpate::scene::Nearest exact = mesh.nearest(p), far = mesh.nearest_or_far(p, within);
  require(std::abs(std::abs(exact.distance) - truth) <= error, "the distance is the smallest of all triangles");
  require(exact.point.allFinite() && far.point.allFinite() && far.normal.allFinite(), "answers are finite");
  const double bound = std::abs(far.distance);
  require(bound <= truth + error, "a bound does not exceed the distance");
  require(bound >= std::min(truth, std::max(within, 15.0 / 16.0 * truth)) - error, "a bound is near the distance");
  const double travelled = mesh.sweep(p, q, radius);
  require(travelled >= 0.0 && travelled <= (q - p).norm() * (1.0 + 1e-9), "a sweep ends on its way");
  (void)mesh.contains(p);
}

/// A damaged image is refused, or gives a mesh that answers.
void read_damaged(const Mesh& mesh, fuzz::Bytes& bytes) {
  std::vector<std::uint8_t> image = mesh.image();
  for (std::size_t k = bytes.below(4); k > 0; --k) {
    const std::size_t at = (256 * std::size_t{bytes.byte()} + bytes.byte()) % image.size();
    image[at] = bytes.byte();
  }
  if (bytes.below(8) == 0) image.resize((256 * std::size_t{bytes.byte()} + bytes.byte()) % image.size());
  try {
    const auto read = Mesh::from_image(image);
    (void)read->nearest(Vec3(0.01, 0.02, 0.03));
  } catch (const std::invalid_argument&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  const double scale = std::pow(10.0, static_cast<double>(bytes.below(5)) - 3.0);
  const auto mesh = fuzz::soup(bytes, scale);
  if (mesh == nullptr) return 0;
  for (int k = 0; k < 3; ++k) query(*mesh, bytes, scale);
  if (bytes.below(4) == 0) read_damaged(*mesh, bytes);
  return 0;
}
