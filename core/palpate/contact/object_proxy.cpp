#include "palpate/contact/object_proxy.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "palpate/contact/normal_gradient.hpp"
#include "palpate/scene/smooth.hpp"
#include "palpate/types/index.hpp"

namespace palpate::contact {
namespace {

constexpr int kQueries = 24;      // nearest-point queries per tick; a proxy that needs more continues in the next tick
constexpr double kCoarse = 5e-3;  // [r] position tolerance of the proxy where the smooth surface determines the force
constexpr double kFine = 1e-7;    // [r] position tolerance where the proxy itself determines the force
constexpr double kQueryRange = 4.0;  // [r] search range for triangles around the proxy
constexpr int kCreaseSteps = 5;      // Newton steps of the proxy on smooth surfaces that meet
constexpr double kLower = 0.5;       // [r] the smooth surface may lie at most this far below the facets
constexpr double kOnEdge = 1e-9;     // a point with a smaller barycentric weight is on the edge (rounding)
const double kOnePatch = std::cos(15.0 * M_PI / 180.0);  // contacts with closer normals are on one smooth patch

constexpr double kFocalLow = 0.1, kFocalHigh = 0.4;  // values of SmoothPoint::focal_factor for zero and full trust
// Cosines between the normals at the proxy and at the tool, for zero and full trust in the projection of the tool.
const double kApart = std::cos(45.0 * M_PI / 180.0), kAgree = std::cos(20.0 * M_PI / 180.0);

/// Linear ramp: 0 below `low`, 1 above `high`.
double ramp(double x, double low, double high) { return std::clamp((x - low) / (high - low), 0.0, 1.0); }

/// Contact with the deflection `depth` [m] times the gradient of the distance. If the depth is not positive, there is
/// no contact, but the normal is still set.
ObjectProxy::ProxyContact contact_from_gradient(const Vec3& gradient, double depth) {
  const double steep = gradient.norm();
  if (!(steep > 0.0)) return {};
  return {depth > 0.0, depth * gradient, gradient / steep, depth * steep, std::max(depth, 0.0)};
}

}  // namespace

ObjectProxy::ProxyContact ObjectProxy::step(const scene::Mesh& mesh, const Vec3& g, double radius,
                                            double release) noexcept {
  if (mesh_ != &mesh || mesh_id_ != mesh.id()) initialise(mesh, g, radius);
  carry();
  if (follow_free_tool(g, radius)) return {};

  queries_left_ = kQueries;
  const bool settled = relax(g, radius, kCoarse);
  tool_ = g;
  if (passed_through(g, radius, release)) {
    initialise(mesh, g, radius);
    return {};
  }
  touching_ = active_.active > 0 || (touching_ && !settled);
  held_ = Held::in_motion;
  if (!settled) return contact_in_motion(g);
  if (!touching_) {
    started_inside_ = false;
    if (near_.triangle < 0 || clear_ >= radius + mesh.impl().topology.height || centre_ != g) return {};
    held_ = Held::above_facets;
    return contact_above_facets(g, radius);
  }
  held_ = Held::smooth_patch;
  const ProxyContact smooth = contact_on_smooth_patch(g, radius);
  if (smooth.touching || smooth.normal != Vec3::Zero()) return limit_to_free_space(smooth, g, radius);
  relax(g, radius, kFine);
  held_ = active_.active == 0 ? Held::in_motion : Held::crease;
  if (active_.active == 0) return contact_in_motion(g);
  return limit_to_free_space(contact_at_crease(g, radius), g, radius);
}

/// Places the proxy for a new mesh: at the tool, or at the nearest point outside.
void ObjectProxy::initialise(const scene::Mesh& mesh, const Vec3& g, double radius) noexcept {
  std::vector<Vec3>* const path = path_;
  *this = ObjectProxy();
  path_ = path;
  mesh_ = &mesh;
  mesh_id_ = mesh.id();
  travelled_ = mesh.impl().travelled;
  centre_ = tool_ = clear_at_ = g;
  const scene::ClosestPoint near = mesh.closest(g, std::numeric_limits<double>::infinity());
  const Vec3 away = g - near.point;
  started_inside_ = mesh.report().closed && near.normal.dot(away) < 0.0;
  if (started_inside_ || near.distance < radius) {
    const Vec3 out =
        near.distance > 0.0 ? Vec3(away / (started_inside_ ? -near.distance : near.distance)) : near.normal;
    centre_ = clear_at_ = near.point + radius * out;
    touching_ = true;
  }
  clear_ = touching_ ? radius : near.distance;
}

/// True if the tool has certainly passed through the object, so that the proxy must be released.
bool ObjectProxy::passed_through(const Vec3& g, double radius, double release) const noexcept {
  return (centre_ - g).squaredNorm() > release * release && mesh_->report().closed &&
         mesh_->nearest(g).distance > radius;
}

/// Carries the proxy along with a mesh that moved: by the mean motion of the points that hold it, which keep their
/// triangles and barycentric weights.
void ObjectProxy::carry() noexcept {
  const scene::Mesh::Impl& m = mesh_->impl();
  carried_.setZero();
  if (m.travelled == travelled_) return;
  for (int i = 0; i < constraint_count_; ++i) {
    const Constraint& held = constraint_[to_index(i)];
    carried_ += (m.position(held.at) - held.q) / constraint_count_;
  }
  if (constraint_count_ > 0) {
    centre_ += carried_;
    clear_at_ += carried_;
  }
  clear_ = std::max(clear_ - (m.travelled - travelled_), 0.0);
  travelled_ = m.travelled;
}

void ObjectProxy::set_centre(const Vec3& centre) noexcept {
  centre_ = centre;
  if (path_ != nullptr) path_->push_back(centre);
}

/// Free motion: the proxy follows the tool without a query while the clearance found by the last query covers the tool.
bool ObjectProxy::follow_free_tool(const Vec3& g, double radius) noexcept {
  const double need = radius + mesh_->impl().topology.height;
  if (touching_ || centre_ != tool_ || (g - clear_at_).norm() + need > clear_) return false;
  set_centre(g);
  tool_ = g;
  return true;
}

double ObjectProxy::free_way(const Vec3& g, double radius) noexcept {
  if (touching_ || started_inside_ || centre_ != g) return 0.0;
  const double range = lookout(radius);
  if (near_.triangle < 0 && clear_ == range) {  // the last query looked no farther
    clear_at_ = g;
    clear_ = std::abs(mesh_->nearest_or_far(g, range).distance);
  }
  return clear_ - (g - clear_at_).norm() - radius - mesh_->impl().topology.height;
}

/// Range in which the proxy searches for triangles [m].
double ObjectProxy::lookout(double radius) const noexcept {
  return kQueryRange * radius + mesh_->impl().topology.height;
}

void ObjectProxy::set_constraint(int i, const scene::BvhHit& hit) noexcept {
  constraint_[to_index(i)].at = {hit.triangle, hit.v, hit.w};
  constraint_[to_index(i)].q = mesh_->impl().position(constraint_[to_index(i)].at);
}

/// Adds the triangle of `hit` as a constraint, or replaces the constraint with the largest gap when there are too many.
void ObjectProxy::add_constraint(const scene::BvhHit& hit, double radius) noexcept {
  int slot = constraint_count_;
  for (int i = 0; i < constraint_count_; ++i)
    if (constraint_[to_index(i)].at.triangle == hit.triangle) slot = i;
  if (slot == kMaxHalfSpaces) {
    slot = 0;
    for (int i = 1; i < constraint_count_; ++i)
      if (half_space_[to_index(i)].gap(centre_) > half_space_[to_index(slot)].gap(centre_)) slot = i;
  }
  constraint_count_ = std::max(constraint_count_, slot + 1);
  set_constraint(slot, hit);
  const Vec3 out = centre_ - constraint_[to_index(slot)].q;
  const double distance = out.norm();
  if (distance > 0.0) half_space_[to_index(slot)].normal = out / distance;
  half_space_[to_index(slot)].offset = half_space_[to_index(slot)].normal.dot(constraint_[to_index(slot)].q) + radius;
}

/// Recomputes the half-spaces for the present position of the proxy. Returns false if there are no constraints.
bool ObjectProxy::linearise(double radius) noexcept {
  for (int i = 0; i < constraint_count_; ++i) {
    const scene::BvhHit hit = mesh_->impl().closest_on(constraint_[to_index(i)].at.triangle, centre_);
    set_constraint(i, hit);
    const double distance = std::sqrt(hit.distance2);
    if (distance > 0.0) half_space_[to_index(i)].normal = (centre_ - constraint_[to_index(i)].q) / distance;
    half_space_[to_index(i)].offset = half_space_[to_index(i)].normal.dot(constraint_[to_index(i)].q) + radius;
  }
  return constraint_count_ > 0;
}

/// Keeps the active constraints only. Queries find the others again when they become active.
void ObjectProxy::keep_active(const Projection& projection) noexcept {
  std::array<Constraint, 3> kept;
  std::array<HalfSpace, 3> kept_space;
  for (int i = 0; i < projection.active; ++i) {
    kept[to_index(i)] = constraint_[to_index(projection.index[to_index(i)])];
    kept_space[to_index(i)] = half_space_[to_index(projection.index[to_index(i)])];
  }
  constraint_count_ = projection.active;
  for (int i = 0; i < constraint_count_; ++i) {
    constraint_[to_index(i)] = kept[to_index(i)];
    half_space_[to_index(i)] = kept_space[to_index(i)];
    active_.index[to_index(i)] = i;
  }
}

/// Longest step for which the centre cannot cross a triangle, with a margin of half the clearance or half a radius.
double ObjectProxy::safe_step(double radius) const noexcept {
  const double clear = std::max(clear_ - (centre_ - clear_at_).norm(), 0.0);
  return std::max(clear - 0.5 * radius, 0.5 * clear);
}

/// Moves the centre towards the point nearest to g that the constraints allow. Returns false if the centre has not
/// arrived after the last query.
bool ObjectProxy::relax(const Vec3& g, double radius, double tolerance) noexcept {
  const double range = lookout(radius);
  linearise(radius);
  active_ = project(half_space_.data(), constraint_count_, g, kSlack * radius);
  bool settled = false;
  while (!settled && queries_left_-- > 0) {
    Vec3 step = active_.feasible ? Vec3(active_.x - centre_) : Vec3::Zero();
    const double length = step.norm(), safe = safe_step(radius);
    const bool whole = length <= safe;
    if (!whole) step *= safe / length;
    set_centre(centre_ + step);

    // The nearest triangle and the known constraints determine the next target.
    near_ = mesh_->impl().closest(centre_, range, seed_);
    if (near_.triangle >= 0) seed_ = near_.triangle;
    clear_at_ = centre_;
    clear_ = near_.triangle >= 0 ? std::sqrt(near_.distance2) : range;
    linearise(radius);
    if (clear_ < radius) add_constraint(near_, radius);
    active_ = project(half_space_.data(), constraint_count_, g, kSlack * radius);
    settled = whole && (!active_.feasible || (active_.x - centre_).norm() <= tolerance * radius);
  }
  if (settled && active_.feasible) set_centre(active_.x);
  keep_active(active_);
  return settled;
}

/// Contact of a proxy that is still far from its target (the tool jumped, or the proxy slid off a rim): the deflection
/// to its present position.
ObjectProxy::ProxyContact ObjectProxy::contact_in_motion(const Vec3& g) const noexcept {
  const Vec3 delta = centre_ - g;
  const double depth = delta.norm();
  if (!touching_ || !(depth > 0.0)) return {};
  return {true, delta, delta / depth, depth, depth};
}

/// Contact of a proxy that does not touch the facets: the smooth surface may rise above them.
ObjectProxy::ProxyContact ObjectProxy::contact_above_facets(const Vec3& g, double radius) const noexcept {
  const scene::Mesh::Impl& m = mesh_->impl();
  const scene::SurfacePoint start{near_.triangle, near_.v, near_.w};
  if (!is_smooth({start, m.position(start)})) return {};
  scene::SmoothPoint s = scene::smooth_project(m, start, g);
  if (!s.found) return {};
  const double side = s.above ? 1.0 : -1.0;
  return contact_from_gradient(side * s.gradient, radius - side * s.distance);
}

/// Normal of the contact if the tool were at g, near its position in the last step. Zero: unknown.
Vec3 ObjectProxy::normal_at(const Vec3& g, double radius) const noexcept {
  switch (held_) {
    case Held::in_motion:
      return (centre_ - g).normalized();
    case Held::above_facets:
      return contact_above_facets(g, radius).normal;
    case Held::smooth_patch:
      return contact_on_smooth_patch(g, radius).normal;
    case Held::crease:
      break;
  }
  if (active_.active > 1 || is_smooth(constraint_[0])) return contact_at_crease(g, radius).normal;
  const scene::BvhHit near = mesh_->impl().closest_on(constraint_[0].at.triangle, g);
  const Vec3 from = g - mesh_->impl().position({near.triangle, near.v, near.w});
  return from.dot(half_space_[0].normal) < 0.0 ? Vec3(-from.normalized()) : from.normalized();
}

Mat3 ObjectProxy::normal_gradient(const Vec3& normal, const Vec3& g, double radius) const noexcept {
  return contact::normal_gradient(normal, radius, [&](const Vec3& d) { return normal_at(g + d, radius); });
}

/// Checks the proxy of the smooth surface against the facets: deep below coarse facets it may be where the sphere does
/// not fit. The proxy moves there from its position on the facets, through free space, as far as possible.
ObjectProxy::ProxyContact ObjectProxy::limit_to_free_space(const ProxyContact& touch, const Vec3& g,
                                                           double radius) const noexcept {
  const Vec3 target = g + touch.delta;
  const double clearance = 0.5 * radius, length = (target - centre_).norm();
  if (!touch.touching || length <= clearance) return touch;
  double travelled = 0.0;
  for (int i = 0; i < kQueries && travelled < length; ++i) {
    const Vec3 p = centre_ + travelled / length * (target - centre_);
    const scene::BvhHit near = mesh_->impl().closest(p, length + radius, seed_);
    const double step = near.triangle < 0 ? length : std::sqrt(near.distance2) - clearance;
    if (step < kCoarse * radius) break;
    travelled += step;
  }
  if (travelled >= length) return touch;
  const Vec3 delta = centre_ + travelled / length * (target - centre_) - g;
  const double depth = delta.norm();
  return depth > 0.0 ? ProxyContact{true, delta, delta / depth, depth, depth} : ProxyContact();
}

/// True if all triangles at the constraint's point belong to one smooth surface: no crease, rim or branch passes
/// through it.
bool ObjectProxy::is_smooth(const Constraint& h) const noexcept {
  const scene::Topology& topology = mesh_->impl().topology;
  const std::int32_t c = 3 * h.at.triangle;
  const double b[3] = {h.at.u(), h.at.v, h.at.w};
  int zeros = 0, zero = 0, one = 0;
  for (int i = 0; i < 3; ++i) {
    if (b[i] <= kOnEdge) {
      ++zeros;
      zero = i;
    } else {
      one = i;
    }
  }
  if (zeros == 0) return true;
  const scene::Stored<std::int32_t>& normal = topology.normal;
  if (zeros == 2) return topology.smooth_vertex[to_index(normal[to_index(c + one)])];
  const std::int32_t he = c + (zero + 1) % 3, next = c + (zero + 2) % 3;
  const std::int32_t twin = topology.twin[to_index(he)];
  if (twin < 0) return false;
  const std::int32_t twin_next = twin % 3 == 2 ? twin - 2 : twin + 1;
  return normal[to_index(he)] == normal[to_index(twin_next)] && normal[to_index(next)] == normal[to_index(twin)];
}

/// Half-space of constraint i on the smooth surface, oriented towards the proxy. At creases it is the facet's
/// half-space.
HalfSpace ObjectProxy::smooth_half_space(int i, double radius) const noexcept {
  const Constraint& h = constraint_[to_index(i)];
  HalfSpace out = half_space_[to_index(i)];
  if (!is_smooth(h)) return out;
  const scene::SmoothPoint s = scene::smooth_at(mesh_->impl(), h.at, centre_);
  const Vec3 normal = s.gradient.normalized();
  const double cosine = normal.dot(out.normal);
  if (!s.found || std::abs(cosine) < 0.5) return out;
  out.normal = cosine < 0.0 ? Vec3(-normal) : normal;
  out.offset = out.normal.dot(s.point) + radius;
  return out;
}

/// The half-space in which a sphere at c clears the smooth surface at constraint i, linearised at c. At creases it is
/// the facet's half-space.
HalfSpace ObjectProxy::smooth_half_space_at(int i, const Vec3& c, double radius) const noexcept {
  const Constraint& h = constraint_[to_index(i)];
  const HalfSpace& facet = half_space_[to_index(i)];
  if (!is_smooth(h)) return facet;
  const scene::SmoothPoint s = scene::smooth_project(mesh_->impl(), h.at, c);
  const double steep = s.gradient.norm(), side = s.gradient.dot(facet.normal) < 0.0 ? -1.0 : 1.0;
  if (!s.found || !(std::abs(s.gradient.dot(facet.normal)) >= 0.5 * steep)) return smooth_half_space(i, radius);
  const Vec3 normal = side / steep * s.gradient;
  return {normal, normal.dot(c) + (radius - side * s.distance) / steep};
}

/// Contact with one smooth patch: depth and direction from the smooth surface. The normal is zero if the constraints do
/// not belong to one patch.
ObjectProxy::ProxyContact ObjectProxy::contact_on_smooth_patch(const Vec3& g, double radius) const noexcept {
  for (int i = 0; i < active_.active; ++i)
    if (!is_smooth(constraint_[to_index(i)])) return {};
  const HalfSpace first = smooth_half_space(0, radius);
  for (int i = 1; i < active_.active; ++i)
    if (smooth_half_space(i, radius).normal.dot(first.normal) < kOnePatch) return {};

  const Vec3& geometric = half_space_[0].normal;
  // The default is the normal where the proxy touches. It is blended with the gradient of the tool's own distance, as
  // far as the tool is away from the focal surface and both normals agree.
  Vec3 normal = first.normal;
  double depth = -first.gap(g);
  const scene::SmoothPoint s = scene::smooth_project(mesh_->impl(), constraint_[0].at, g);
  if (s.found) {
    const double side = s.gradient.dot(geometric) < 0.0 ? -1.0 : 1.0;
    const double trust = ramp(s.focal_factor, kFocalLow, kFocalHigh) *
                         ramp(side * s.gradient.normalized().dot(first.normal), kApart, kAgree);
    normal = trust * side * s.gradient + (1.0 - trust) * normal;
    depth = trust * (radius - side * s.distance) + (1.0 - trust) * depth;
  }
  const double least = -half_space_[0].gap(g) - kLower * radius;
  return contact_from_gradient(normal, std::max(depth, least));
}

/// Contact at creases and corners: the deflection follows from the half-spaces.
ObjectProxy::ProxyContact ObjectProxy::contact_at_crease(const Vec3& g, double radius) const noexcept {
  // The proxy on the smooth surfaces is found by Newton's method from that on the facets. Where it has converged, the
  // force is the gradient of 1/2 K |proxy - tool|^2, the least over all proxies that clear the surfaces.
  std::array<HalfSpace, 3> h;
  Projection p;
  p.x = centre_;
  for (int step = 0; step < kCreaseSteps; ++step) {
    const Vec3 at = p.x;
    for (int i = 0; i < active_.active; ++i) h[to_index(i)] = smooth_half_space_at(i, at, radius);
    p = project(h.data(), active_.active, g, kSlack * radius);
    if (p.active == 0 || (p.x - at).norm() < kFine * radius || (p.x - centre_).norm() > radius) break;
  }
  ProxyContact out;
  if (p.active == 0) {  // here the smooth surface lies below the facets, but at most by kLower
    const Vec3 delta = centre_ - g;
    const double length = delta.norm();
    return length > kLower * radius ? contact_from_gradient(delta / length, length - kLower * radius) : out;
  }
  // In a cleft the rotated half-spaces may meet far from the proxy. The smooth surface is near the facets, so the new
  // centre stays within one radius of the proxy.
  const Vec3 off = p.x - centre_;
  const double far = off.norm();
  out.delta = (far > radius ? Vec3(centre_ + radius / far * off) : p.x) - g;
  out.depth = out.stretch = out.delta.norm();
  if (!(out.depth > 0.0)) return {};
  out.touching = true;
  // Only a centre on one half-space's plane is displaced along that half-space's normal; a limited centre is not.
  out.normal = p.active == 1 && far <= radius ? h[to_index(p.index[0])].normal : Vec3(out.delta / out.depth);
  return out;
}

}  // namespace palpate::contact
