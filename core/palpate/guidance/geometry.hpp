// The geometry of a fixture. Points, curves, surfaces, solids and their combinations answer the same query; roles and
// laws use only its answer and do not depend on the shape.
#pragma once

#include <limits>
#include <memory>

#include "palpate/scene/frame.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::guidance {

/// Where the tool lies relative to a geometry, in the frame in which its pose was given (W in the cycle).
struct Query {
  double distance = 0.0;             ///< signed: negative inside a solid; never negative for points and curves [m]
  Vec3 normal = Vec3::UnitZ();       ///< unit vector outwards: direction of the distance's gradient
  double gradient_norm = 1.0;        ///< norm of that gradient: 1, except where a blend fills a crease
  Vec3 point = Vec3::Zero();         ///< nearest point of the geometry [m]
  Mat3 basis = Mat3::Identity();     ///< rotation matrix: two tangents and the normal as columns
  Vec3 velocity = Vec3::Zero();      ///< velocity of the geometry's material at `point` [m/s]
  Vec3 spin = Vec3::Zero();          ///< angular velocity of the geometry [rad/s]
  Mat3 attitude = Mat3::Identity();  ///< rotation of the frame at `point`: z is the axis of a line, path or cone; a
                                     ///< recorded path gives the tool's rotation, other geometries their own axes
  double arc_length = 0.0;           ///< arc length from the start of a path or line to `point` [m]; 0 elsewhere
  int dimension = 2;  ///< how many leading columns of `basis` lie along the geometry: 0 at points, 1 on curves, else 2
};

/// Derivatives of a query with respect to the tool's position p, for roles whose target direction depends on it.
struct QueryDerivatives {
  Vec3 normal = Vec3::Zero();      ///< mean of the distance's gradients nearby; shorter than one where they disagree
  Mat3 d_normal = Mat3::Zero();    ///< d normal / dp [1/m]
  Mat3 d_attitude = Mat3::Zero();  ///< d (rotation vector of the attitude) / dp [rad/m]
};

using scene::LiveFrames;

/// A shape. It is immutable; its frame moves it (geometry/framed.hpp). Distances are exact unless a class says
/// otherwise.
class Geometry {
 public:
  virtual ~Geometry() = default;
  Geometry() = default;
  Geometry(const Geometry&) = delete;
  Geometry& operator=(const Geometry&) = delete;

  /// The query at time t [s] for a tool at X_WT. Finite for every finite pose and time: coordinates are clamped to
  /// `kMaxCoordinate`. Allocation free. Farther than `exact_within` [m] from the geometry, the distance has the right
  /// sign and may be a lower bound (Surface::nearest_or_far): exact queries in the middle of a lumen take long.
  [[nodiscard]] Query query(const Pose& X_WT, double t, double exact_within = kEverywhere) const noexcept;
  /// The mean normal around the tool's position, by central differences of the distance over kDifferenceStep along each
  /// of the geometry's axes. d_normal is the exact derivative of that mean. Six queries.
  [[nodiscard]] virtual QueryDerivatives normals(const Pose& X_WT, double t) const noexcept;
  /// The derivative of the attitude with respect to the tool's position, limited to kMaxTurnPerLength where the
  /// attitude jumps. Six queries.
  [[nodiscard]] QueryDerivatives attitude_derivative(const Pose& X_WT, double t) const noexcept;
  /// True if the geometry has an inside. The role `keep-in` needs it, and so do `forbid` and `limit` without a margin.
  [[nodiscard]] virtual bool solid() const noexcept = 0;
  /// True if the geometry is a single point.
  [[nodiscard]] virtual bool is_point() const noexcept { return false; }
  /// True if z of the attitude is a meaningful axis. It is not for a point, a ball or a cloud that has not been
  /// rotated.
  [[nodiscard]] virtual bool has_axis() const noexcept { return true; }
  /// Appends the live frames to which the geometry is attached.
  virtual void add_live(LiveFrames& /*frames*/) const {}

  static constexpr double kEverywhere = std::numeric_limits<double>::infinity();
  static constexpr double kMaxCoordinate = 1e6;       ///< largest coordinate [m]
  static constexpr double kDifferenceStep = 0.01;     ///< half width of the differences in normals() [m]
  static constexpr double kMaxTurnPerLength = 100.0;  ///< largest norm of the derivative of an attitude [rad/m]

 protected:
  /// The query for coordinates within kMaxCoordinate and times within 1e9 s, to which query() clamps them.
  [[nodiscard]] virtual Query query_local(const Pose& X_WT, double t, double exact_within) const noexcept = 0;
};

using GeometryPtr = std::shared_ptr<const Geometry>;

/// A rotation whose third column is the unit vector `normal`. It is not continuous in `normal` everywhere.
[[nodiscard]] Mat3 basis_of(const Vec3& normal) noexcept;
/// The same, with the first column as near to the unit vector `along` as the normal allows.
[[nodiscard]] Mat3 basis_of(const Vec3& normal, const Vec3& along) noexcept;
/// The query for points and curves: distance and normal from the nearest point `point` to p [m]. tangent: unit tangent
/// of a curve at `point`; null for a point and beyond the end of a curve.
[[nodiscard]] Query point_or_curve_query(const Vec3& p, const Vec3& point, const Vec3* tangent) noexcept;

}  // namespace palpate::guidance
