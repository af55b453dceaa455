// A contact method and a fixture geometry in a library of one's own.
#include <nanobind/eigen/dense.h>
#include "palpate/contact/registry.hpp"
#include "palpate/guidance/geometry.hpp"

using namespace palpate;

// Touches 1 mm before the tool does: a proxy with a larger sphere.
std::unique_ptr<contact::Method> make_early(const contact::Options& given) {
  contact::Options options = given;
  options.radius += 1e-3;
  return contact::make_method("proxy", options);
}

// All points within a radius of the line between two places.
struct Rod final : guidance::Geometry {
  Rod(const Vec3& a, const Vec3& b, double radius) : a_(a), ab_(b - a), radius_(radius) {}
  bool solid() const noexcept override { return true; }

  guidance::Query query_local(const Pose& X_WT, double, double) const noexcept override {
    const double s = std::clamp(ab_.dot(X_WT.p - a_) / ab_.squaredNorm(), 0.0, 1.0);
    guidance::Query q = guidance::point_or_curve_query(X_WT.p, a_ + s * ab_, nullptr);
    q.distance -= radius_;
    q.point += radius_ * q.normal;
    q.dimension = 2;
    return q;
  }
  Vec3 a_, ab_;
  double radius_;
};

NB_MODULE(_own_parts, m) {
  contact::register_method("early", &make_early);
  nanobind::class_<Rod, guidance::Geometry>(m, "Rod").def(nanobind::init<const Vec3&, const Vec3&, double>());
}
