// What a fixture is made of: one question, the same answer from points, curves, surfaces, solids and what is built of
// them. Roles and laws ask it and know nothing of the shape.
#pragma once

#include <memory>
#include <vector>

#include "palpate/types/spatial.hpp"

namespace palpate::guidance {

/// The answer to "where is the tool?", in the frame that the pose was given in (W in the cycle).
struct Query {
  double distance = 0.0;             ///< signed: below zero inside of a solid; of points and curves never [m]
  Vec3 normal = Vec3::UnitZ();       ///< unit, outwards: the direction of the distance's gradient
  double steep = 1.0;                ///< length of that gradient: 1 but where a blend fills a crease
  Vec3 point = Vec3::Zero();         ///< nearest place of the geometry [m]
  Mat3 basis = Mat3::Identity();     ///< a rotation: two tangents and, third, the normal
  Vec3 velocity = Vec3::Zero();      ///< of the geometry's material at `point` [m/s]
  Vec3 spin = Vec3::Zero();          ///< angular velocity of the geometry [rad/s]
  Mat3 attitude = Mat3::Identity();  ///< the frame that belongs to `point`: its z is the axis of lines, paths and
                                     ///< cones; a recorded path gives the tool's; others the geometry's own axes
  double along = 0.0;                ///< how far along a path or a line `point` is [m]; 0 elsewhere
  int dimension = 2;                 ///< leading tangents that lie along the geometry: 0 at points, 1 along curves
};

/// What the answer is around the tool's place p, for roles whose aim goes with the place.
struct Around {
  Vec3 normal = Vec3::Zero();    ///< mean of the distance's gradient; shorter than one where the normals disagree
  Mat3 d_normal = Mat3::Zero();  ///< d normal / dp [1/m]
  Mat3 turn = Mat3::Zero();      ///< the rotation vector of the attitude's turn, by dp [rad/m]
};

class LiveFrame;
using LiveFrames = std::vector<std::shared_ptr<LiveFrame>>;

/// Immutable once built; what moves is where it is (frame.hpp). Distances are exact unless a class says otherwise.
class Geometry {
 public:
  virtual ~Geometry() = default;
  Geometry() = default;
  Geometry(const Geometry&) = delete;
  Geometry& operator=(const Geometry&) = delete;

  /// At time t [s], for a tool at X_WT. Finite for every finite pose and time: what lies beyond `kFarthest` is answered
  /// as if it were at the edge. Allocation free.
  [[nodiscard]] Query query(const Pose& X_WT, double t) const noexcept;
  /// The normals around the same place, over kAround either way along each of the geometry's axes: by central
  /// differences of the distance, so that d_normal is exact. Six queries.
  [[nodiscard]] virtual Around normals(const Pose& X_WT, double t) const noexcept;
  /// How the attitude turns with the place: six queries. Where it leaps, as fast as kSharpest lets it.
  [[nodiscard]] Around turns(const Pose& X_WT, double t) const noexcept;
  /// It has an inside: `forbid` and `keep-in` have a meaning.
  [[nodiscard]] virtual bool solid() const noexcept = 0;
  /// It is one place.
  [[nodiscard]] virtual bool is_point() const noexcept { return false; }
  /// The attitude's z is an axis that a person would name: not of a point, a ball or a cloud that nobody has turned.
  [[nodiscard]] virtual bool has_axis() const noexcept { return true; }
  /// Adds the frames that it is attached to and that are told live.
  virtual void add_live(LiveFrames& /*frames*/) const {}

  static constexpr double kFarthest = 1e6;    ///< of coordinates [m]
  static constexpr double kAround = 0.01;     ///< [m]
  static constexpr double kSharpest = 100.0;  ///< most that an attitude turns by [rad/m]

 protected:
  /// As `query`, for coordinates within kFarthest and times within 1e9 s.
  [[nodiscard]] virtual Query answer(const Pose& X_WT, double t) const noexcept = 0;
};

using GeometryPtr = std::shared_ptr<const Geometry>;

/// A rotation whose third column is the unit vector `normal`. Turns with it, but not everywhere continuously.
[[nodiscard]] Mat3 basis_of(const Vec3& normal) noexcept;
/// The same with the first column as near to the unit vector `along` as the normal lets it.
[[nodiscard]] Mat3 basis_of(const Vec3& normal, const Vec3& along) noexcept;
/// The answer of points and curves: distance and normal from p to its nearest place; `tangent` of a curve, else null.
[[nodiscard]] Query towards(const Vec3& p, const Vec3& point, const Vec3* tangent) noexcept;

}  // namespace palpate::guidance
