#include "palpate/verify/soak.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "palpate/scene/snapshot.hpp"
#include "palpate/types/random.hpp"

namespace palpate::verify {
namespace {

constexpr double kTick = 1e-3;   // [s] period of a tick
constexpr int kTries = 4;        // draws per pass on average, because a draw may find no free space to begin in
constexpr double kTurn = 0.1;    // [rad] largest rotation of a swaying object
constexpr double kLever = 0.05;  // [m] distance from the pivot at which this rotation keeps within object_speed

/// Checks a segment against every triangle.
class Judge {
 public:
  explicit Judge(const scene::Mesh& mesh) {
    const std::span<const double> v = mesh.vertices();
    const std::span<const std::int32_t> t = mesh.triangles();
    for (std::size_t i = 0; i < t.size(); i += 3) {
      const auto corner = [&](std::size_t k) { return Vec3(&v[3 * static_cast<std::size_t>(t[i + k])]); };
      const Vec3 a = corner(0), e1 = corner(1) - a, e2 = corner(2) - a;
      facets_.push_back({e1.cross(e2), e1.cross(e2).dot(a), a, e1, e2});
    }
  }

  [[nodiscard]] bool crosses(const Vec3& p, const Vec3& q) const {
    return std::any_of(facets_.begin(), facets_.end(), [&](const Facet& f) {
      const double from = f.normal.dot(p) - f.offset, to = f.normal.dot(q) - f.offset;
      if (from * to > 0.0 || from == to) return false;
      const Vec3 x = p + from / (from - to) * (q - p) - f.a;
      const double area = f.normal.squaredNorm();
      const double v = x.cross(f.e2).dot(f.normal) / area, w = f.e1.cross(x).dot(f.normal) / area;
      return v >= 0.0 && w >= 0.0 && v + w <= 1.0;
    });
  }

 private:
  struct Facet {
    Vec3 normal;
    double offset;
    Vec3 a, e1, e2;
  };
  std::vector<Facet> facets_;
};

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double between(double low, double high) { return low + (high - low) * uniform(engine_); }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(engine_() % n); }
  Vec3 direction() {
    for (;;) {
      const Vec3 x(between(-1, 1), between(-1, 1), between(-1, 1));
      const double length = x.norm();
      if (length > 0.1 && length < 1.0) return x / length;
    }
  }

 private:
  std::mt19937_64 engine_;
};

/// The motions of tool and object in W.
struct Motion {
  Vec3 start, in, drag;        // start [m], unit vector into the surface, later displacement along it [m]
  double entry_length, speed;  // distance moved along `in` [m], speed of the whole motion [m/s]
  bool tool_rests;             // the object moves instead of the tool
  Vec3 sway, axis, pivot;      // sinusoidal motion of the object: amplitude [m], rotation vector [rad] about the pivot
  double sway_rate;            // angular frequency of the sway [rad/s]

  [[nodiscard]] int ticks() const { return static_cast<int>((entry_length + drag.norm()) / (speed * kTick)) + 2; }
  [[nodiscard]] Vec3 way(int k) const {
    const double s = k * kTick * speed, dragged = drag.norm();
    const Vec3 p = std::min(s, entry_length) * in;
    return dragged > 0.0 ? Vec3(p + std::clamp((s - entry_length) / dragged, 0.0, 1.0) * drag) : p;
  }
  [[nodiscard]] Vec3 tool(int k) const { return tool_rests ? start : Vec3(start + way(k)); }
  [[nodiscard]] Pose object(int k) const {
    const double swing = std::sin(sway_rate * kTick * k);
    const Mat3 R = Eigen::AngleAxisd(swing * axis.norm(), axis.normalized()).toRotationMatrix();
    const Vec3 p = pivot - R * pivot + swing * sway;
    return {R, tool_rests ? Vec3(p - way(k)) : p};
  }
};

/// Draws a free start position and a path through the surface. Returns false if the start position is not free.
bool draw(const scene::Mesh& mesh, const SoakRange& range, Random& random, SoakPass& pass, Motion& m) {
  const std::span<const double> v = mesh.vertices();
  const std::span<const std::int32_t> t = mesh.triangles();
  const std::size_t i = 3 * random.below(t.size() / 3);
  const auto corner = [&](std::size_t k) { return Vec3(&v[3 * static_cast<std::size_t>(t[i + k])]); };
  const Vec3 a = corner(0), e1 = corner(1) - a, e2 = corner(2) - a;
  double b = random.between(0, 1), c = random.between(0, 1);
  if (b + c > 1.0) b = 1.0 - b, c = 1.0 - c;
  Vec3 n = e1.cross(e2).normalized();
  if (!mesh.report().closed && random.below(2) == 0) n = -n;
  const double tilt = random.between(0, range.angle);
  const Vec3 aside = n.cross(random.direction()).normalized();

  pass.radius = range.radius_min * std::pow(range.radius_max / range.radius_min, random.between(0, 1));
  pass.depth = random.between(0, range.depth);
  m.tool_rests = random.below(3) == 0;
  const bool sways = !m.tool_rests && random.below(2) == 0;
  pass.object_moves = m.tool_rests || sways;
  pass.speed = m.speed = random.between(range.speed_min, m.tool_rests ? range.object_speed : range.speed_max);
  m.in = -std::cos(tilt) * n + std::sin(tilt) * aside;
  const double off = 1.1 * pass.radius / std::cos(tilt) + 1e-3;
  m.pivot = a + b * e1 + c * e2;
  m.start = m.pivot - off * m.in;
  m.entry_length = off + pass.depth;
  m.drag = random.between(0, range.drag) * random.direction();
  const double reach =
      random.between(1e-3, 10e-3);  // amplitude of the sway; sway_rate limits its largest speed, in the middle
  m.sway = sways ? Vec3(reach * random.direction()) : Vec3::Zero();
  m.sway_rate = random.between(0.1, 1.0) * range.object_speed / reach;
  const double turn = std::min(kTurn, range.object_speed / (kLever * m.sway_rate));
  m.axis = sways ? Vec3(turn * random.direction()) : Vec3::Zero();
  return n.allFinite() && mesh.nearest(m.start).distance > 1.01 * pass.radius;
}

/// Runs one pass. Returns true if the proxy crossed the surface.
bool poke(scene::Snapshot& scene, const Judge& judge, contact::Method& method, const Motion& m, SoakReport& report) {
  method.reset();
  const int ticks = m.ticks();
  bool touched = false, crossed = false;
  Vec3 before = m.start, tool_before = m.start;
  std::vector<Vec3> path;
  method.record_path(&path);
  for (int k = 0; k < ticks && !crossed; ++k) {
    const Pose X_WO = scene.objects[0].X_WO = m.object(k);
    const Vec3 tool = m.tool(k);
    const ContactSet& contacts = method.step(scene, tool, (tool - tool_before) / kTick, k * kTick);
    if (method.asynchronous()) method.collide(scene);
    tool_before = tool;
    touched |= contacts.size > 0;
    const Vec3 p_WP = contacts.size > 0 ? contacts.contact[0].p_proxy : tool;
    const Vec3 p_OP = X_WO.R.transpose() * (p_WP - X_WO.p);
    if (path.empty()) path.push_back(p_OP);
    if (k == 0) before = path.front();
    for (const Vec3& p : path) {
      crossed |= judge.crosses(before, p);
      before = p;
    }
    crossed |= judge.crosses(before, p_OP);  // the reported proxy lies on the same side as its path
    path.clear();
    ++report.ticks;
  }
  report.touched += touched ? 1 : 0;
  return crossed;
}

}  // namespace

SoakReport soak(const std::shared_ptr<const scene::Mesh>& mesh, std::string_view method, std::int64_t passes,
                std::uint64_t seed, const SoakRange& range) {
  const Judge judge(*mesh);
  Random random(seed);
  scene::Snapshot scene;
  scene::Object& object = scene.objects.emplace_back();
  object.surface = mesh;
  SoakReport report;
  for (std::int64_t i = 0; report.passes < passes && i < kTries * passes; ++i) {
    SoakPass pass;
    Motion motion;
    pass.index = i;
    if (!draw(*mesh, range, random, pass, motion)) continue;
    contact::Options options;
    options.radius = pass.radius;
    const std::unique_ptr<contact::Method> m = contact::make_method(method, options);
    ++report.passes;
    if (!poke(scene, judge, *m, motion, report)) continue;
    if (report.crossed++ == 0) report.first_crossed = pass;
  }
  return report;
}

}  // namespace palpate::verify
