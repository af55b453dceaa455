#include "palpate/tissue/soft_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include "palpate/scene/smooth.hpp"
#include "palpate/types/index.hpp"

namespace palpate::tissue {
namespace {

constexpr double kWidth = 0.7;               // [edge] of the spread force
constexpr double kFast = 0.05;               // [edge] displacement in a step beyond which steps are halved
constexpr double kTooFast = 0.5;             // [edge] displacement in a step that is a divergence
constexpr double kStill = 0.1, kRamp = 0.3;  // [s] after a divergence: standing still, then a ramp of the loads
constexpr double kMaxLoad = 30.0;            // [N] largest force of one contact on the body
constexpr double kPublish = 0.016;           // [s] shortest time between two published surfaces

/// The surface as a mesh that can move, without the inner nodes.
std::shared_ptr<scene::Mesh> mesh_of(const BodyData& data) {
  if (data.surface.empty()) throw std::invalid_argument("tissue: surface has no triangles");
  std::vector<std::int32_t> row(data.nodes.size() / 3, -1), triangles;
  std::vector<double> vertices;
  for (const std::int32_t node : data.surface) {
    if (row[to_index(node)] < 0) {
      row[to_index(node)] = static_cast<std::int32_t>(vertices.size() / 3);
      const auto at = data.nodes.begin() + 3 * static_cast<std::ptrdiff_t>(node);
      vertices.insert(vertices.end(), at, at + 3);
    }
    triangles.push_back(row[to_index(node)]);
  }
  return scene::Mesh::build(vertices, triangles)->movable();
}

/// Node for each vertex of the mesh, which may have been welded and reordered: the one at the same position.
std::vector<std::int32_t> nodes_of(const scene::Mesh& mesh, const BodyData& data) {
  std::map<std::array<double, 3>, std::int32_t> node_at;
  for (const std::int32_t node : data.surface) {
    const double* const x = &data.nodes[3 * to_index(node)];
    node_at[{x[0], x[1], x[2]}] = node;
  }
  std::vector<std::int32_t> out;
  const std::span<const double> x = mesh.vertices();
  for (std::size_t i = 0; i < x.size(); i += 3) out.push_back(node_at.at({x[i], x[i + 1], x[i + 2]}));
  return out;
}

double mean_edge(const scene::Mesh& mesh) {
  const scene::Mesh::Impl& m = mesh.impl();
  double sum = 0.0;
  const auto count = static_cast<std::int32_t>(m.triangles.size());
  for (std::int32_t he = 0; he < count; ++he) sum += (m.corner(scene::next_half_edge(he)) - m.corner(he)).norm();
  return sum / count;
}

double plane_modulus(double mu, double bulk) {  // E / (1 - nu^2)
  const double poisson = (3.0 * bulk - 2.0 * mu) / (2.0 * (3.0 * bulk + mu));
  return 2.0 * mu / (1.0 - poisson);
}

/// E* of the tetrahedron behind each triangle: of the one that shares the most corners.
std::vector<double> plane_moduli(const scene::Mesh& mesh, const BodyData& data, const std::vector<std::int32_t>& node) {
  std::vector<std::vector<std::int32_t>> around(data.nodes.size() / 3);
  for (std::size_t k = 0; k < data.tets.size(); ++k)
    around[to_index(data.tets[k])].push_back(static_cast<std::int32_t>(k / 4));
  std::vector<double> out;
  for (std::size_t c = 0; c < mesh.triangles().size(); c += 3) {
    std::map<std::int32_t, int> shared;
    for (std::size_t k = c; k < c + 3; ++k)
      for (const std::int32_t tet : around[to_index(node[to_index(mesh.triangles()[k])])]) ++shared[tet];
    const auto most = std::max_element(shared.begin(), shared.end(),
                                       [](const auto& x, const auto& y) { return x.second < y.second; });
    const std::size_t tet = to_index(most->first);
    out.push_back(plane_modulus(data.mu[tet], data.bulk[tet]));
  }
  return out;
}

}  // namespace

SoftSurface::SoftSurface(BodyData data, double width, std::uint64_t continues)
    : Surface(continues),
      body_(std::move(data)),
      mesh_(mesh_of(body_.data())),
      edge_(mean_edge(*mesh_)),
      vertices_(mesh_->vertices().begin(), mesh_->vertices().end()),
      published_(vertices_) {
  auto tables = std::make_shared<Tables>();
  tables->rest = mesh_->movable();
  tables->spreading = Spreading(mesh_->vertices(), mesh_->triangles(), width > 0.0 ? width : kWidth * edge_);
  tables->node = nodes_of(*mesh_, body_.data());
  tables->plane_modulus = plane_moduli(*mesh_, body_.data(), tables->node);
  tables_ = tables;
  safe_u_.assign(3 * body_.node_count(), 0.0);
  still_ = safe_u_;
  for (const PronyTerm& term : body_.data().prony) instantaneous_ += term.g;
}

SoftSurface::SoftSurface(const SoftSurface& from, std::uint64_t id)
    : Surface(id),
      body_(from.body_),
      tables_(from.tables_),
      mesh_(from.mesh_->movable()),
      edge_(from.edge_),
      instantaneous_(from.instantaneous_),
      vertices_(tables_->rest->vertices().begin(), tables_->rest->vertices().end()),
      published_(vertices_),
      safe_u_(from.still_),
      still_(from.still_) {
  body_.reset();
  mesh_->move(vertices_);
}

std::shared_ptr<scene::Surface> SoftSurface::at_rest() const {
  return std::shared_ptr<SoftSurface>(new SoftSurface(*this, id()));
}

// The touched surface is X + K u between the vertices, with the roundness that it has at rest. A contact method may see
// it rounder, because a dent of a few facets looks round to it; the depth is corrected by the difference.
SoftSurface::Site SoftSurface::locate(const scene::SpherePlace& place) const noexcept {
  const scene::BvhHit hit = mesh_->impl().closest(place.p_OC, std::numeric_limits<double>::infinity(), -1);
  Site site{{hit.triangle, hit.v, hit.w}, place.depth};
  if (hit.triangle < 0) return site;
  const Vec3 facet = mesh_->impl().position(site.at), rest = tables_->rest->impl().position(site.at);
  const scene::SmoothPoint round = scene::smooth_at(tables_->rest->impl(), site.at, rest);
  const double height = round.found ? -round.distance : 0.0;
  const double higher = place.normal.dot(facet - place.p_OC) + height;
  site.depth = std::clamp(place.depth + higher, 0.5 * place.depth, 1.5 * place.depth);
  return site;
}

LocalLaw SoftSurface::law_at(const scene::SurfacePoint& at, double radius) const noexcept {
  const double b[3] = {at.u(), at.v, at.w}, modulus = tables_->plane_modulus[to_index(at.triangle)];
  return {modulus, radius, tables_->spreading.yield(at.triangle, b) / modulus};
}

/// Mean of a quantity of the nodes under the spread load of a contact point.
Vec3 SoftSurface::spread(const scene::SurfacePoint& at, std::span<const double> nodal) const noexcept {
  const double b[3] = {at.u(), at.v, at.w};
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    const std::int32_t vertex = mesh_->triangles()[to_index(3 * at.triangle + k)];
    for (const Spreading::Entry& e : tables_->spreading.row(vertex))
      sum += b[k] * e.weight * Vec3(&nodal[3 * to_index(tables_->node[to_index(e.vertex)])]);
  }
  return sum;
}

/// Force of the Prony springs of the near field [N].
double SoftSurface::viscous_force(int sphere, double elastic) const noexcept {
  double sum = 0.0;
  const auto& terms = body_.data().prony;
  for (std::size_t i = 0; i < terms.size() && sphere < kSpheres; ++i)
    sum += terms[i].g * (elastic - memory_[to_index(sphere)][i]);
  return sum;
}

scene::Response SoftSurface::respond(const scene::SpherePlace& at) const noexcept {
  scene::Response out;
  if (!(at.depth > 0.0)) return out;
  const Site site = locate(at);
  if (site.at.triangle < 0) return out;
  const LocalLaw::Value value = law_at(site.at, at.radius).at(site.depth);
  const double force = std::max(value.force + viscous_force(at.sphere, value.force), 0.0);
  out.force = force;
  out.stiffness = force / at.depth;
  out.tangent = instantaneous_ * value.tangent;
  out.stored = value.stored;
  out.velocity = spread(site.at, body_.velocities());
  return out;
}

void SoftSurface::advance(std::span<const scene::SurfaceLoad> loads, double dt) noexcept {
  take(loads);
  relax(dt);
  std::copy(body_.displacements().begin(), body_.displacements().end(), safe_u_.begin());
  if (frozen_ <= kRamp) {
    const int halves = hurried_ ? 2 : 1;
    const int steps = std::max(1, static_cast<int>(std::lround(dt / body_.time_step())));
    for (int i = 0; i < steps * halves; ++i) {
      push();
      body_.step(halves);
    }
  }
  guard(dt);
  move_surface();
  publish(dt);
}

void SoftSurface::remember(std::span<const scene::SurfaceLoad> loads, double dt) noexcept {
  take(loads);
  relax(dt);
}

void SoftSurface::follow(std::span<const double> displacements, std::span<const double> velocities,
                         double dt) noexcept {
  body_.set_state(displacements, velocities);
  move_surface();
  publish(dt);
}

void SoftSurface::take(std::span<const scene::SurfaceLoad> loads) noexcept {
  touches_ = 0;
  for (const scene::SurfaceLoad& load : loads) {
    Touch touch;
    const Site site = locate(load.at);
    touch.at = site.at;
    if (touch.at.triangle < 0 || touches_ == static_cast<int>(touch_.size()) || !load.force.allFinite()) continue;
    touch.law = law_at(touch.at, load.at.radius);
    touch.sphere = load.at.sphere;
    touch.depth = site.depth;
    const double elastic = touch.law.at(touch.depth).force;
    touch.viscous = viscous_force(load.at.sphere, elastic) - elastic * (instantaneous_ - 1.0);
    touch.secant = touch.depth > 0.0 ? std::max(load.force.dot(load.at.normal), 0.0) / touch.depth : 0.0;
    touch.normal = load.at.normal;
    touch.force = load.force - load.at.normal * load.at.normal.dot(load.force);
    touch.start = spread(touch.at, body_.displacements());
    touch_[to_index(touches_++)] = touch;
  }
}

/// Puts the forces of the contacts on the body, each a spring to the tool that follows the surface.
void SoftSurface::push() noexcept {
  body_.clear_loads();
  const double ramp = std::clamp(1.0 - frozen_ / kRamp, 0.0, 1.0);
  for (int i = 0; i < touches_; ++i) {
    const Touch& touch = touch_[to_index(i)];
    const Vec3 moved = spread(touch.at, body_.displacements()) - touch.start;
    const double along = touch.normal.dot(moved);
    const double normal_force = std::max(instantaneous_ * touch.law.at(touch.depth + along).force + touch.viscous, 0.0);
    Vec3 force = normal_force * touch.normal + touch.force + touch.secant * (moved - along * touch.normal);
    const double size = force.norm();
    if (!(size > 0.0) || !std::isfinite(size)) continue;
    force *= -ramp * std::min(1.0, kMaxLoad / size);
    const double b[3] = {touch.at.u(), touch.at.v, touch.at.w};
    for (int k = 0; k < 3; ++k) {
      const std::int32_t vertex = mesh_->triangles()[to_index(3 * touch.at.triangle + k)];
      for (const Spreading::Entry& e : tables_->spreading.row(vertex))
        body_.add_load(tables_->node[to_index(e.vertex)], b[k] * e.weight * force);
    }
  }
}

/// Advances the viscous memory of the near fields; spheres without contact forget.
void SoftSurface::relax(double dt) noexcept {
  const auto& terms = body_.data().prony;
  for (int s = 0; s < kSpheres && !terms.empty(); ++s) {
    double elastic = 0.0;
    for (int i = 0; i < touches_; ++i)
      if (touch_[to_index(i)].sphere == s) elastic = touch_[to_index(i)].law.at(touch_[to_index(i)].depth).force;
    for (std::size_t i = 0; i < terms.size(); ++i) {
      double& q = memory_[to_index(s)][i];
      q += -std::expm1(-dt / terms[i].tau) * (elastic - q);
    }
  }
}

/// Answers fast motion with shorter steps, and a divergence with a return to the last displacements, at rest.
void SoftSurface::guard(double dt) noexcept {
  const double fastest = body_.fastest();
  if (!(fastest <= kTooFast * edge_)) {
    body_.reset();
    body_.set_state(safe_u_, still_);
    frozen_ = kStill + kRamp;
    hurried_ = true;
    return;
  }
  frozen_ = std::max(frozen_ - dt, 0.0);
  hurried_ = frozen_ > 0.0 || fastest > (hurried_ ? 0.25 : 1.0) * kFast * edge_;
}

/// Moves the touched surface to X + K u.
void SoftSurface::move_surface() noexcept {
  for (std::size_t i = 0; i < tables_->node.size(); ++i) {
    const double* const rest = &body_.data().nodes[3 * to_index(tables_->node[i])];
    Vec3 u = Vec3::Zero();
    for (const Spreading::Entry& e : tables_->spreading.row(static_cast<std::int32_t>(i)))
      u += e.weight * body_.displacement(tables_->node[to_index(e.vertex)]);
    for (std::size_t k = 0; k < 3; ++k) vertices_[3 * i + k] = rest[k] + u[static_cast<Eigen::Index>(k)];
  }
  mesh_->move(vertices_);
}

void SoftSurface::publish(double dt) noexcept {
  unpublished_ += dt;
  if (unpublished_ < kPublish) return;
  unpublished_ = 0.0;
  published_.write(vertices_);
}

scene::DeformableState SoftSurface::state() const noexcept {
  const BodyEnergy energy = body_.energy();
  return {energy.potential, energy.kinetic, hurried_, frozen_ > 0.0};
}

}  // namespace palpate::tissue
