#include "runtime/device/shared_library.h"

#include <dlfcn.h>

#include "runtime/base/error.h"

namespace beatlas::device {

std::vector<std::string> one_or(const std::string& library, std::vector<std::string> names) {
  if (library.empty()) return names;
  return {library};
}

SharedLibrary::SharedLibrary(const std::vector<std::string>& names, const std::string& what)
    : what_(what) {
  for (const std::string& name : names) {
    handle_ = ::dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
    name_ = name;
    if (handle_ != nullptr) return;
  }
  throw Error(ErrorCode::Machine,
              what + " is not installed (" + names.front() +
                  " cannot be loaded); install the vendor's driver, name its library with "
                  "--device-library, or use another --device");
}

SharedLibrary::~SharedLibrary() { ::dlclose(handle_); }

void* SharedLibrary::symbol(const char* name) const {
  void* const found = ::dlsym(handle_, name);
  if (found == nullptr) {
    throw Error(ErrorCode::Machine, name_ + " exports no " + name + "; it is not the library of " +
                                        what_ + " that beatlas knows");
  }
  return found;
}

}  // namespace beatlas::device
