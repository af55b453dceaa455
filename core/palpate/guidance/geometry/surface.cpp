#include "palpate/guidance/geometry/surface.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "palpate/scene/cloud.hpp"
#include "palpate/scene/deformable.hpp"
#include "palpate/scene/deformed_scope.hpp"
#include "palpate/scene/mesh.hpp"
#include "palpate/scene/primitives.hpp"

namespace palpate::guidance {
namespace {

constexpr double kTouch = 1e-7;  // [m] closer to a mesh, the vector to its nearest point is mostly rounding error
constexpr int kNoSphere = std::numeric_limits<int>::max();  // no sphere of the tool: without viscous memory

}  // namespace

Solid::Solid(std::shared_ptr<const scene::Surface> surface) : surface_(std::move(surface)) {
  if (surface_ == nullptr) throw std::invalid_argument("a surface is needed");
  const scene::Mesh* mesh = surface_->mesh();
  soft_ = surface_->deformable() != nullptr;
  closed_ = mesh == nullptr || mesh->report().closed;
  const scene::Surface* any = surface_.get();
  axis_ = dynamic_cast<const scene::Sphere*>(any) == nullptr && dynamic_cast<const scene::Cloud*>(any) == nullptr;
}

Query Solid::query_local(const Pose& X_WT, double, double exact_within) const noexcept {
  const scene::Surface& surface = soft_ ? scene::DeformedScope::present(*surface_) : *surface_;
  const scene::Nearest found = surface.nearest_or_far(X_WT.p, exact_within);
  Query q;
  q.distance = found.distance;
  q.point = found.point;
  q.normal = found.normal;
  // A mesh returns the normal of its surface, which near edges is not the gradient of the distance.
  const double far = std::abs(q.distance);
  if (surface.mesh() != nullptr && far > kTouch && far < exact_within) q.normal = (X_WT.p - q.point) / q.distance;
  q.basis = basis_of(q.normal);
  if (soft_) q.velocity = surface.deformable()->velocity(q.point);
  return q;
}

}  // namespace palpate::guidance
