#pragma once
#include <string>
#include <vector>

namespace beatlas::device {

/// `library` alone, if one is named, or else those that a vendor's library is installed as.
[[nodiscard]] std::vector<std::string> one_or(const std::string& library,
                                              std::vector<std::string> names);

/// A vendor's library, found when it is wanted: nothing of it is needed to build or to start.
class SharedLibrary {
 public:
  /// Opens the first of `names` that can be loaded.
  /// @param what of whom, for messages: "OpenHaptics of 3D Systems".
  /// @throws Error{Machine} if none can.
  SharedLibrary(const std::vector<std::string>& names, const std::string& what);
  ~SharedLibrary();
  SharedLibrary(const SharedLibrary&) = delete;
  SharedLibrary& operator=(const SharedLibrary&) = delete;

  /// Sets `function` to what is exported under `name`. @throws Error{Machine} if nothing is.
  template <class Function>
  void bind(const char* name, Function*& function) const {
    function = reinterpret_cast<Function*>(symbol(name));
  }

 private:
  [[nodiscard]] void* symbol(const char* name) const;

  void* handle_ = nullptr;
  std::string what_;
  std::string name_;
};

}  // namespace beatlas::device
