// Contact methods of other libraries: register_method() adds one by name, without a change of this one.
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

#include "palpate/contact/contact.hpp"

namespace palpate::contact {

/// Makes a method for one sphere. It may throw std::invalid_argument for options that the method cannot take.
using Maker = std::unique_ptr<Method> (*)(const Options&);

/// Sizes of the types that a method shares with the core, by which a library that was compiled against other headers
/// is recognised.
inline constexpr std::size_t kLayout = sizeof(Options) + (sizeof(ContactSet) << 16) + (sizeof(scene::Snapshot) << 40);

/// Adds the contact method `name`, for every tool that is made from now on. The library must stay loaded. Any thread
/// may call it, and a repeated call with the same function changes nothing.
/// Throws std::invalid_argument for an empty name, a name that is taken, and a library that was compiled against other
/// headers.
void register_method(std::string_view name, Maker make, std::size_t layout = kLayout);

}  // namespace palpate::contact
