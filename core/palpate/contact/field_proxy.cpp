#include "palpate/contact/field_proxy.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "palpate/contact/normal_gradient.hpp"
#include "palpate/types/index.hpp"

namespace palpate::contact {
namespace {

constexpr int kSteps = 24;          // steps per tick; a proxy that needs more continues in the next tick
constexpr double kSettled = 1e-6;   // [r] position tolerance of the proxy
constexpr double kTouch = 1e-4;     // [r] tolerance of the clearance r: rounding, and the error of a grid
constexpr double kShort = 1.5;      // [r] a shorter path crosses nothing when both ends are r away; 2 is the limit
constexpr double kSameFace = 0.7;   // smallest cosine between normals that may follow each other within one tick
constexpr double kTrust = 0.9;      // factor on two overlapping clearances: the distances of a grid are not exact
constexpr double kFree = 0.5;       // factor on a clearance that a free tool may move without a query
constexpr double kSameWall = 0.5;   // cosine: a wall whose normal turned by more is another wall
constexpr double kEscape = 0.25;    // [r] step of a proxy whose centre is inside a second wall
constexpr double kWallRange = 2.0;  // [r] nearer walls constrain the proxy

}  // namespace

FieldProxy::ProxyContact FieldProxy::step(const scene::Surface& surface, const Vec3& g, double radius,
                                          double release) noexcept {
  const bool replaced = surface_ != &surface;
  surface_ = &surface;
  radius_ = radius;
  if (replaced && surface_id_ == surface.id()) near_ = surface.nearest(centre_);  // the next frame of a stream
  tool_ = surface.nearest(g);
  const bool passed_through = touching_ && (centre_ - g).squaredNorm() > release * release && tool_.distance > radius;
  if (surface_id_ != surface.id() || passed_through) initialise(g);
  if (follow_free_tool(g)) return {};
  projected_ = project_tool(g);
  const bool settled = projected_ || relax(g);
  if (settled && !projected_) projected_ = project_tool(g);
  if (projected_) {
    const double depth = radius - tool_.distance;
    return {true, depth * tool_.normal, tool_.normal, depth, depth};
  }
  if (settled || active_.active > 0) touching_ = active_.active > 0;
  if (!touching_) started_inside_ = false;
  return touching_ ? contact_from_deflection(g) : ProxyContact();
}

/// Places the proxy for a new surface: at the tool, or at the nearest point outside.
void FieldProxy::initialise(const Vec3& g) noexcept {
  surface_id_ = surface_->id();
  walls_ = 0;
  active_ = Projection();
  started_inside_ = tool_.distance < 0.0;
  touching_ = tool_.distance < radius_;
  set_centre(touching_ ? Vec3(tool_.point + radius_ * tool_.normal) : g);
}

/// Sets the centre and finds its nearest surface point.
void FieldProxy::set_centre(const Vec3& centre) noexcept {
  centre_ = centre;
  near_ = surface_->nearest(centre);
}

/// Moves the proxy to a tool that is free, if the clearances of both cover the path between them. Returns false
/// otherwise.
bool FieldProxy::follow_free_tool(const Vec3& g) noexcept {
  if (tool_.distance < radius_ || near_.distance <= 0.0) return false;
  if ((g - centre_).norm() > kTrust * (tool_.distance + near_.distance)) return false;
  centre_ = g;
  near_ = tool_;
  touching_ = started_inside_ = false;
  walls_ = 0;
  return true;
}

double FieldProxy::free_way(const Vec3& g) const noexcept {
  return touching_ || started_inside_ || centre_ != g ? 0.0 : kFree * (tool_.distance - radius_);
}

void FieldProxy::follow(const scene::Surface& surface, const Vec3& g) noexcept {
  if (surface_id_ != surface.id()) return;  // step() places the proxy anew
  surface_ = &surface;
  centre_ = g;
  near_ = surface.nearest(g);
}

/// Moves the proxy to the point r above the surface point nearest to the tool, if this point is on the proxy's side and
/// the sphere fits there. Returns false otherwise.
bool FieldProxy::project_tool(const Vec3& g) noexcept {
  const double depth = radius_ - tool_.distance;
  if (!(depth > 0.0)) return false;
  const Vec3 above = g + depth * tool_.normal;
  if ((above - centre_).norm() > kShort * radius_ || near_.distance < (1.0 - kTouch) * radius_) return false;
  if (tool_.normal.dot(near_.normal) < kSameFace) return false;
  const scene::Nearest nearest = surface_->nearest(above);
  if (nearest.distance < (1.0 - kTouch) * radius_) return false;  // another wall is in the way
  centre_ = above;
  near_ = nearest;
  touching_ = true;
  walls_ = 0;
  add_wall(nearest);
  return true;
}

/// Moves the centre towards the point nearest to g that the walls allow. Returns false if the centre has not arrived.
bool FieldProxy::relax(const Vec3& g) noexcept {
  for (int step = 0; step < kSteps; ++step) {
    follow_walls();
    if (near_.distance < kWallRange * radius_) add_wall(near_);
    for (int i = 0; i < walls_; ++i) {
      const Vec3 out = centre_ - wall_[to_index(i)].q;
      const double distance = out.norm();
      const Vec3 n =
          distance > 0.0 && out.dot(wall_[to_index(i)].n) > 0.0 ? Vec3(out / distance) : wall_[to_index(i)].n;
      half_space_[to_index(i)] = {n, n.dot(wall_[to_index(i)].q) + radius_};
    }
    active_ = project(half_space_.data(), walls_, g, kSlack * radius_);
    if (!active_.feasible) return false;  // the walls have no common point: the proxy stays where it is
    const Vec3 displacement = active_.x - centre_;
    const double length = displacement.norm();
    if (length <= kSettled * radius_) {
      keep_active();
      return true;
    }
    const double safe = near_.distance > 0.0 ? 0.5 * near_.distance : kEscape * radius_;
    set_centre(centre_ + displacement * std::min(1.0, safe / length));
  }
  return false;
}

/// Stores a wall: in place of the same wall found earlier, or of the farthest one when there are too many.
void FieldProxy::add_wall(const scene::Nearest& near) noexcept {
  int slot = walls_;
  for (int i = 0; i < walls_; ++i)
    if ((wall_[to_index(i)].q - near.point).norm() < 0.01 * radius_ &&
        wall_[to_index(i)].n.dot(near.normal) > kSameWall)
      slot = i;
  if (slot == kMaxHalfSpaces) {
    slot = 0;
    for (int i = 1; i < walls_; ++i)
      if ((wall_[to_index(i)].q - centre_).norm() > (wall_[to_index(slot)].q - centre_).norm()) slot = i;
  }
  walls_ = std::max(walls_, slot + 1);
  wall_[to_index(slot)] = {near.point, near.normal};
}

/// Updates the nearest point of each wall, which is searched from the projection of the centre onto the wall's plane.
/// Walls whose normal turned too far are dropped.
void FieldProxy::follow_walls() noexcept {
  int kept = 0;
  for (int i = 0; i < walls_; ++i) {
    const Wall& wall = wall_[to_index(i)];
    const Vec3 foot = centre_ - wall.n * wall.n.dot(centre_ - wall.q);
    const scene::Nearest nearest = surface_->nearest(foot);
    if (nearest.normal.dot(wall.n) < kSameWall) continue;
    wall_[to_index(kept++)] = {nearest.point, nearest.normal};
  }
  walls_ = kept;
}

/// Keeps the active walls only. The others are found again when they become active.
void FieldProxy::keep_active() noexcept {
  std::array<Wall, 3> kept;
  for (int i = 0; i < active_.active; ++i) kept[to_index(i)] = wall_[to_index(active_.index[to_index(i)])];
  walls_ = active_.active;
  std::copy_n(kept.begin(), walls_, wall_.begin());
}

Mat3 FieldProxy::normal_gradient(const Vec3& normal, const Vec3& g) const noexcept {
  if (projected_)
    return contact::normal_gradient(normal, radius_, [&](const Vec3& d) { return surface_->nearest(g + d).normal; });
  if (active_.active != 1)
    return contact::normal_gradient(normal, radius_, [&](const Vec3& d) {
      return (project(half_space_.data(), walls_, g + d, kSlack * radius_).x - g - d).normalized();
    });
  // One wall: H (I - depth H)^-1 with the curvature H at the proxy.
  const Mat3 H =
      contact::normal_gradient(normal, radius_, [&](const Vec3& d) { return surface_->nearest(centre_ + d).normal; });
  const Mat3 ahead = Mat3::Identity() - (centre_ - g).norm() * H;
  return std::abs(ahead.determinant()) > 1e-6 ? Mat3(H * ahead.inverse()) : Mat3::Zero();
}

/// Contact of a proxy that is held by walls or still moving: the deflection to its present position.
FieldProxy::ProxyContact FieldProxy::contact_from_deflection(const Vec3& g) const noexcept {
  const Vec3 delta = centre_ - g;
  const double depth = delta.norm();
  if (!(depth > 0.0)) return {};
  return {true, delta, delta / depth, depth, depth};
}

}  // namespace palpate::contact
