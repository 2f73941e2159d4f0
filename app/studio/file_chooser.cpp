// SPDX-License-Identifier: MIT
#include "app/studio/file_chooser.h"

#include <imgui/imgui.h>
#include <imgui/imgui_stdlib.h>

#include <algorithm>

#include "app/studio/theme.h"
#include "engine/core/file_io.h"

namespace airclay {
namespace {

constexpr std::size_t kMostListed = 5000;  // longer lists are truncated; a name can be typed

}  // namespace

void FileChooser::open(const std::string& title, const std::filesystem::path& folder,
                       std::vector<std::string> extensions, bool to_write, Chosen chosen) {
  title_ = title;
  extensions_ = std::move(extensions);
  to_write_ = to_write;
  chosen_ = std::move(chosen);
  name_.clear();
  open_ = true;
  asked_ = false;
  std::error_code error;
  goTo(std::filesystem::is_directory(folder, error) ? folder : std::filesystem::current_path(error));
}

void FileChooser::goTo(const std::filesystem::path& folder) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(folder, error);
  std::vector<Listed> listed;
  for (std::filesystem::directory_iterator at(whole, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    std::error_code ignored;
    const bool is_folder = at->is_directory(ignored);
    const bool listable = is_folder || std::find(extensions_.begin(), extensions_.end(),
                                                 lowerCaseExtension(at->path())) != extensions_.end();
    if (!name.starts_with(".") && listable) listed.push_back({name, is_folder});
    if (listed.size() == kMostListed) break;
  }
  if (error) {
    error_ = whole.string() + ": " + error.message();
    return;
  }
  std::sort(listed.begin(), listed.end(), [](const Listed& a, const Listed& b) {
    return a.is_folder != b.is_folder ? a.is_folder : a.name < b.name;
  });
  listed_ = std::move(listed);
  folder_ = whole;
  error_.clear();
}

bool FileChooser::accept() {
  if (name_.empty()) return false;
  std::filesystem::path file =
      std::filesystem::path(name_).is_absolute() ? std::filesystem::path(name_) : folder_ / name_;
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) {
    goTo(file);
    name_.clear();
    return false;
  }
  if (to_write_ && file.extension().empty()) file += extensions_.front();
  if (!to_write_ && !std::filesystem::exists(file, error)) {
    error_ = "No such file: " + file.string();
    return false;
  }
  chosen_(file);
  return true;
}

void FileChooser::drawList() {
  ImGui::BeginChild("files", ImVec2(ImGui::GetFontSize() * 30, ImGui::GetFontSize() * 16), true);
  std::filesystem::path next;
  if (ImGui::Selectable("..  Parent folder")) next = folder_.parent_path();
  for (const Listed& entry : listed_) {
    if (entry.is_folder) {
      if (ImGui::Selectable((entry.name + "/").c_str())) next = folder_ / entry.name;
    } else if (ImGui::Selectable(entry.name.c_str(), entry.name == name_)) {
      name_ = entry.name;
    }
  }
  ImGui::EndChild();
  if (!next.empty()) goTo(next);
}

void FileChooser::draw() {
  if (!open_) return;
  if (!asked_) ImGui::OpenPopup(title_.c_str());
  asked_ = true;
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(size.x / 2, size.y / 2), ImGuiCond_Always, ImVec2(0.5f, 0.5f));
  if (!ImGui::BeginPopupModal(title_.c_str(), nullptr, ImGuiWindowFlags_AlwaysAutoResize)) {
    open_ = false;
    return;
  }
  ImGui::TextDisabled("%s", folder_.c_str());
  drawList();
  if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
  ImGui::SetNextItemWidth(ImGui::GetFontSize() * 30);
  const bool entered =
      ImGui::InputTextWithHint("##name", "Name", &name_, ImGuiInputTextFlags_EnterReturnsTrue);
  if (!error_.empty()) ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(theme::kBad), "%s", error_.c_str());
  bool done = false;
  if (ImGui::Button(to_write_ ? "Save" : "Open") || entered) done = accept();
  ImGui::SameLine();
  if (ImGui::Button("Cancel") || ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false)) done = true;
  if (done) {
    ImGui::CloseCurrentPopup();
    open_ = false;
  }
  ImGui::EndPopup();
}

}  // namespace airclay
