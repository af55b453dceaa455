// The contact methods of the paper and those that it rejects, which find contacts by collisions of triangles. Coal
// computes the collisions, so that these methods are a library of their own.
#pragma once

namespace palpate::collision {

/// Adds the methods to the registry of the contact stage. A repeated call changes nothing.
void register_methods();

}  // namespace palpate::collision
