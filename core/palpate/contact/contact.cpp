#include "palpate/contact/contact.hpp"

#include <cmath>
#include <list>
#include <mutex>
#include <stdexcept>
#include <string>

#include "palpate/contact/penalty.hpp"
#include "palpate/contact/proxy.hpp"
#include "palpate/contact/registry.hpp"

namespace palpate::contact {
namespace {

struct Entry {
  std::string name;
  Maker make;
};

template <class T>
std::unique_ptr<Method> make(const Options& options) {
  return std::make_unique<T>(options);
}

/// All contact methods, the default first. A new method needs one file and one line here, or a call of
/// register_method() in a library of its own, as palpate/collision makes it.
class Registry {
 public:
  static Registry& get() {
    static Registry all;
    return all;
  }
  /// Calls visit(entry) for each method until it returns true.
  template <class Visit>
  void any(const Visit& visit) {
    const std::scoped_lock lock(mutex_);
    for (const Entry& entry : entries_) {
      if (visit(entry)) return;
    }
  }
  /// Adds a method; false if its name belongs to another one.
  bool add(std::string_view name, Maker make) {
    const std::scoped_lock lock(mutex_);
    for (const Entry& entry : entries_) {
      if (entry.name == name) return entry.make == make;
    }
    entries_.push_back({std::string(name), make});
    return true;
  }

 private:
  std::mutex mutex_;
  std::list<Entry> entries_ = {
      {"proxy", &make<Proxy>},
      {"penalty", &make<Penalty>},
  };
};

}  // namespace

std::vector<std::string> methods() {
  std::vector<std::string> names;
  Registry::get().any([&](const Entry& entry) {
    names.push_back(entry.name);
    return false;
  });
  return names;
}

void register_method(std::string_view name, Maker make, std::size_t layout) {
  const std::string what = "contact: method '" + std::string(name) + "' ";
  if (name.empty() || make == nullptr)
    throw std::invalid_argument("contact: a method needs a name and a function that makes it");
  if (layout != kLayout)
    throw std::invalid_argument(what + "was compiled against headers of another version of palpate; compile it again");
  if (!Registry::get().add(name, make)) throw std::invalid_argument(what + "exists already; give it another name");
}

Vec3 ToolSphere::centre(double jaw) const noexcept {
  const double length = axis.norm();
  return length > 0.0 ? Vec3(hinge + Eigen::AngleAxisd(length * jaw, axis / length) * (p - hinge)) : p;
}

std::unique_ptr<Method> make_method(std::string_view name, const Options& options) {
  if (!(options.radius > 0.0) || !std::isfinite(options.radius))
    throw std::invalid_argument("contact: radius must be a positive length in metres, got " +
                                std::to_string(options.radius));
  if (options.objects < 1 || options.objects > scene::kMaxObjects)
    throw std::invalid_argument("contact: objects must be from 1 to " + std::to_string(scene::kMaxObjects) + ", got " +
                                std::to_string(options.objects));
  std::string known;
  Maker make = nullptr;
  Registry::get().any([&](const Entry& entry) {
    if (entry.name == name) make = entry.make;
    known += (known.empty() ? "" : ", ") + entry.name;
    return make != nullptr;
  });
  if (make == nullptr)
    throw std::invalid_argument("contact: no method '" + std::string(name) + "'; there are: " + known);
  return make(options);
}

}  // namespace palpate::contact
