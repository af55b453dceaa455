#include "palpate/collision/coal_surface.hpp"

#include <coal/BVH/BVH_model.h>
#include <coal/collision.h>
#include <coal/shape/geometric_shapes.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "palpate/scene/mesh.hpp"

namespace palpate::collision {

struct CoalSurface::Tree : coal::BVHModel<coal::OBBRSS> {
  std::vector<Vec3> face_normals;  ///< outward unit normals; zero for a triangle without area
};

struct CoalSurface::Sphere : coal::Sphere {
  using coal::Sphere::Sphere;
};

CoalSurface::CoalSurface(double radius) : sphere_(std::make_unique<Sphere>(radius)) {}
CoalSurface::~CoalSurface() = default;

void CoalSurface::prepare(const scene::Snapshot& scene) {
  const auto in_scene = [&scene](std::uint64_t id) {
    return std::any_of(scene.objects.begin(), scene.objects.end(),
                       [id](const scene::Object& o) { return o.surface->id() == id; });
  };
  std::erase_if(trees_, [&](const auto& tree) { return !in_scene(tree.first); });

  for (const scene::Object& object : scene.objects) {
    const scene::Mesh* mesh = object.surface->mesh();
    if (!mesh) {
      continue;
    }
    std::unique_ptr<Tree>& tree = trees_[mesh->id()];
    if (tree) {
      continue;
    }
    const auto vertices = mesh->vertices();
    const auto triangles = mesh->triangles();
    std::vector<coal::Vec3s> points;
    points.reserve(vertices.size() / 3);
    for (std::size_t i = 0; i < vertices.size(); i += 3) {
      points.emplace_back(vertices[i], vertices[i + 1], vertices[i + 2]);
    }
    std::vector<coal::Triangle> faces;
    faces.reserve(triangles.size() / 3);
    for (std::size_t i = 0; i < triangles.size(); i += 3) {
      faces.emplace_back(triangles[i], triangles[i + 1], triangles[i + 2]);
    }
    auto new_tree = std::make_unique<Tree>();
    new_tree->beginModel(static_cast<unsigned>(faces.size()), static_cast<unsigned>(points.size()));
    new_tree->addSubModel(points, faces);
    new_tree->endModel();
    for (const coal::Triangle& f : faces) {
      const Vec3 normal = (points[f[1]] - points[f[0]]).cross(points[f[2]] - points[f[0]]);
      new_tree->face_normals.push_back(normal.squaredNorm() > 0.0 ? normal.normalized() : Vec3::Zero());
    }
    tree = std::move(new_tree);
  }
}

CollisionPoints CoalSurface::collide(const scene::Object& object, const Vec3& p_OT) const {
  if (!object.surface->mesh()) {
    return {};
  }
  const auto tree = trees_.find(object.surface->id());
  if (tree == trees_.end() || !tree->second) {
    throw std::logic_error("CoalSurface: the mesh of '" + object.name +
                           "' was not prepared: call prepare(scene) first");
  }
  const coal::Transform3s X_OO, X_OT(p_OT);
  const coal::CollisionRequest request(coal::CONTACT, kMaxCollisionPoints);
  coal::CollisionResult result;
  coal::collide(tree->second.get(), X_OO, sphere_.get(), X_OT, request, result);

  CollisionPoints points;
  const std::size_t n = std::min<std::size_t>(result.numContacts(), kMaxCollisionPoints);
  for (std::size_t i = 0; i < n; ++i) {
    const coal::Contact& c = result.getContact(i);
    const Vec3& n_face = tree->second->face_normals[static_cast<std::size_t>(c.b1)];
    const CollisionPoint point{c.nearest_points[0], c.normal, n_face, -c.penetration_depth};
    if (point.p.allFinite() && point.n.allFinite() && point.depth > 0.0) {
      points.point[static_cast<std::size_t>(points.size++)] = point;
    }
  }
  return points;
}

}  // namespace palpate::collision
