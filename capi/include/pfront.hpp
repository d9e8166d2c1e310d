// pfront for C++17: objects that free themselves, exceptions in place of statuses, and spans. All of it is in this header; link the
// library as from C. What each function does, and how long what it returns is good, pfront.h says beside the function that it calls.
//
//     const float points[] = {0, 0, 0, 4, 0, 0, 0, 4, 0};
//     const std::uint32_t corners[] = {0, 1, 2};
//     pfront::model floor(pfront::mesh(points, corners));
//     pfront::scene scene;
//     std::uint64_t body = scene.add(floor);
//     for (const auto& [a, b] : scene.intersecting_bodies()) { ... }

#ifndef PFRONT_HPP
#define PFRONT_HPP

#include "pfront.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#if defined(__has_include) && __cplusplus >= 202002L
#if __has_include(<span>)
#include <span>
#endif
#endif

namespace pfront {

#ifdef __cpp_lib_span
using std::span;
#else
// What std::span is in C++20: elements of somebody else's.
template <class T>
class span {
public:
    constexpr span() noexcept = default;
    constexpr span(T* data, std::size_t size) noexcept : data_(data), size_(size) {}
    template <std::size_t N>
    constexpr span(T (&array)[N]) noexcept : data_(array), size_(N) {}
    // Of whatever has data and size, as std::vector and std::array have.
    template <class C, class = decltype(static_cast<T*>(std::declval<C&>().data()))>
    constexpr span(C&& container) noexcept : data_(container.data()), size_(container.size()) {}

    constexpr T* data() const noexcept { return data_; }
    constexpr std::size_t size() const noexcept { return size_; }
    constexpr bool empty() const noexcept { return size_ == 0; }
    constexpr T* begin() const noexcept { return data_; }
    constexpr T* end() const noexcept { return data_ + size_; }
    constexpr T& operator[](std::size_t i) const noexcept { return data_[i]; }

private:
    T* data_ = nullptr;
    std::size_t size_ = 0;
};
#endif

using pose = pfront_pose_t;
using pose64 = pfront_pose64_t;
using pair = pfront_pair_t;
using buffers = pfront_buffers_t;
using hit = pfront_scene_hit_t;

inline constexpr pose identity = PFRONT_POSE_IDENTITY;

// A status other than PFRONT_OK. `detail` has the parameter, vertex or triangle at fault; `what()` is a sentence with them.
class error : public std::runtime_error {
public:
    explicit error(const pfront_error_t& told) : std::runtime_error(text(told)), detail(told) {}
    pfront_error_t detail;

private:
    static std::string text(const pfront_error_t& told) {
        std::string text = pfront_error_text(told.status);
        if (told.what) {
            text += std::string(" (") + told.what + ", index " + std::to_string(told.index) + ", needed " +
                    std::to_string(told.needed) + ", given " + std::to_string(told.given) + ")";
        }
        return text;
    }
};

namespace detail {

// Calls a function of C, whose last parameter is the error, and throws that.
template <class F, class... A>
void call(F function, A... arguments) {
    pfront_error_t told{};
    if (function(arguments..., &told) != PFRONT_OK) throw error(told);
}

// The object that a function of C makes. To free one while another thread is inside a call with it ends the program, since that
// thread would go on in memory that is gone.
template <auto Free>
struct release {
    template <class T>
    void operator()(T* object) const noexcept {
        if (Free(object, nullptr) == PFRONT_BUSY) std::terminate();
    }
};
template <class T, auto Free>
using handle = std::unique_ptr<T, release<Free>>;

template <class T, auto Free, class F, class... A>
handle<T, Free> made(F function, A... arguments) {
    T* object = nullptr;
    pfront_error_t told{};
    if (function(arguments..., &object, &told) != PFRONT_OK) throw error(told);
    return handle<T, Free>(object);
}

// The list that a function of C returns.
template <class T, class F, class... A>
span<const T> list(F function, A... arguments) {
    const T* elements = nullptr;
    std::size_t count = 0;
    call(function, arguments..., &elements, &count);
    return span<const T>(elements, count);
}

// The element that a function of C finds, if there is one.
template <class T, class F, class... A>
std::optional<T> found(F function, A... arguments) {
    T element{};
    std::uint32_t is_there = 0;
    call(function, arguments..., &element, &is_there);
    return is_there ? std::optional<T>(element) : std::nullopt;
}

template <class S, class I>
buffers mesh(span<const S> positions, span<const I> triangles) {
    if (positions.size() % 3 != 0 || triangles.size() % 3 != 0) {
        throw std::invalid_argument("pfront: positions and triangles are three numbers each");
    }
    const std::uint32_t type = sizeof(I) == 2 ? PFRONT_INDEX_U16 : PFRONT_INDEX_U32;
    return buffers{positions.data(), positions.size() / 3, 3 * sizeof(S), triangles.data(), triangles.size() / 3, type};
}

// The numbers of a container of numbers, or of rows of three.
template <class C>
auto numbers(const C& container) {
    const auto* first = std::data(container);
    using T = std::remove_cv_t<std::remove_reference_t<decltype(*first)>>;
    if constexpr (std::is_arithmetic_v<T>) {
        return span<const T>(first, std::size(container));
    } else {
        using N = std::remove_cv_t<std::remove_reference_t<decltype((*first)[0])>>;
        static_assert(std::is_arithmetic_v<N> && sizeof(T) == 3 * sizeof(N), "rows are of three numbers");
        return span<const N>(reinterpret_cast<const N*>(first), 3 * std::size(container));
    }
}

// Calls the function for float or that for double, whichever the positions are of.
template <class P, class F, class... What>
void set_positions(const P& positions, F in_float, F in_double, What... what) {
    const auto coordinates = numbers(positions);
    using S = std::remove_const_t<std::remove_pointer_t<decltype(coordinates.data())>>;
    static_assert(std::is_same_v<S, float> || std::is_same_v<S, double>, "positions are float or double");
    if (coordinates.size() % 3 != 0) throw std::invalid_argument("pfront: positions are three numbers each");
    const auto function = std::is_same_v<S, float> ? in_float : in_double;
    call(function, what..., static_cast<const void*>(coordinates.data()), coordinates.size() / 3, std::size_t{0});
}

}  // namespace detail

inline const char* version() noexcept { return pfront_version(); }

// A mesh of two containers: x, y, z of each vertex, and three vertices a triangle, in rows of three or one number after the other.
// Positions are float, or double for `model::from_f64`; indices have 16 or 32 bits. Both must outlive it.
template <class P, class T>
buffers mesh(const P& positions, const T& triangles) {
    return detail::mesh(detail::numbers(positions), detail::numbers(triangles));
}

inline pose inverse(const pose& pose_) {
    pose inverse_{};
    detail::call(pfront_pose_inverse, &pose_, &inverse_);
    return inverse_;
}

// The pose a_from_c of a_from_b and b_from_c.
inline pose multiply(const pose& a_from_b, const pose& b_from_c) {
    pose a_from_c{};
    detail::call(pfront_pose_multiply, &a_from_b, &b_from_c, &a_from_c);
    return a_from_c;
}

namespace detail {
inline std::vector<pair> taken(pfront_pair_list_t& list) {
    struct guard {
        pfront_pair_list_t& list;
        ~guard() { pfront_pair_list_free(&list, nullptr); }
    } guarded{list};
    return std::vector<pair>(list.pairs, list.pairs + list.count);
}
}  // namespace detail

// All pairs of triangles that meet, sorted; once, without a model.
inline std::vector<pair> all(const buffers& a, const buffers& b, const pose& a_from_b = identity) {
    pfront_pair_list_t list{};
    detail::call(pfront_all, &a, &b, &a_from_b, static_cast<const pfront_allocator_t*>(nullptr), &list);
    return detail::taken(list);
}

inline std::vector<pair> self(const buffers& mesh, pfront_rule_t rule = PFRONT_SHARED_INDEX) {
    pfront_pair_list_t list{};
    detail::call(pfront_self, &mesh, static_cast<std::uint32_t>(rule), static_cast<const pfront_allocator_t*>(nullptr), &list);
    return detail::taken(list);
}

inline std::optional<pair> any(const buffers& a, const buffers& b, const pose& a_from_b = identity) {
    return detail::found<pair>(pfront_any, &a, &b, &a_from_b, static_cast<const pfront_allocator_t*>(nullptr));
}

// A mesh and its BVH; any number of scenes and threads may use one.
class model {
public:
    explicit model(const buffers& mesh) : model(detail::made<pfront_model_t, pfront_model_free>(pfront_model_create, &mesh)) {}
    static model from_f64(const buffers& mesh) {
        return model(detail::made<pfront_model_t, pfront_model_free>(pfront_model_create_f64, &mesh));
    }
    static model from_blob(span<const std::byte> blob) {
        return model(detail::made<pfront_model_t, pfront_model_free>(
            pfront_model_from_blob, static_cast<const void*>(blob.data()), blob.size()));
    }
    // The vertices in its own frame, as for `scene::set_positions`; the threads of `on` refit it, or the calling one.
    template <class P>
    void set_positions(const P& positions, const pfront_executor_t* on = nullptr) {
        detail::set_positions(positions, pfront_model_set_positions, pfront_model_set_positions_f64, object_.get(), on);
    }
    const pfront_model_t* get() const noexcept { return object_.get(); }

private:
    using handle = detail::handle<pfront_model_t, pfront_model_free>;
    explicit model(handle object) : object_(std::move(object)) {}
    handle object_;
};

// Threads or a GPU that answer.
class executor {
public:
    explicit executor(pfront_device_t device, std::uint32_t workers = 1)
        : object_(detail::made<pfront_executor_t, pfront_executor_free>(
              pfront_executor_create, static_cast<std::uint32_t>(device), workers)) {}
    const pfront_executor_t* get() const noexcept { return object_.get(); }

private:
    detail::handle<pfront_executor_t, pfront_executor_free> object_;
};

// What is asked about: two models, the second in a pose, or one and itself. Models and pose must outlive the question.
inline pfront_subject_t subject(const model& a, const model& b, const pose& a_from_b = identity) {
    return {a.get(), b.get(), &a_from_b, nullptr, PFRONT_SHARED_INDEX};
}
inline pfront_subject_t subject(const model& a, const model& b, const pose64& a_from_b) {
    return {a.get(), b.get(), nullptr, &a_from_b, PFRONT_SHARED_INDEX};
}
inline pfront_subject_t subject(const model& a, pfront_rule_t rule = PFRONT_SHARED_INDEX) {
    return {a.get(), nullptr, nullptr, nullptr, static_cast<std::uint32_t>(rule)};
}

// A query about models, for one thread at a time; its lists are good until the same question is asked again.
class query {
public:
    query() : query(nullptr) {}
    explicit query(const executor& on) : query(on.get()) {}
    // Asks for pairs at most so far apart from now on; 0 for those that intersect.
    void within(float distance) { detail::call(pfront_model_query_within, object_.get(), distance); }
    span<const pair> all(const pfront_subject_t& subject) { return detail::list<pair>(pfront_model_query_all, object_.get(), &subject); }
    std::optional<pair> any(const pfront_subject_t& subject) {
        return detail::found<pair>(pfront_model_query_any, object_.get(), &subject);
    }
    // How far apart two models are, if at most `limit`.
    std::optional<pfront_gap_t> distance(const pfront_subject_t& subject, float limit = INFINITY) {
        return detail::found<pfront_gap_t>(pfront_model_query_distance, object_.get(), &subject, limit);
    }
    // The relation of two solids, exactly.
    pfront_between_t relation(const pfront_subject_t& subject) {
        pfront_between_t between{};
        detail::call(pfront_model_query_relation, object_.get(), &subject, &between);
        return between;
    }
    // The least and the greatest that the volume can be that two solids have in common.
    std::array<double, 2> overlap_volume(const pfront_subject_t& subject) {
        std::array<double, 2> volume{};
        detail::call(pfront_model_query_overlap_volume, object_.get(), &subject, &volume[0], &volume[1]);
        return volume;
    }
    std::uint64_t count(const pfront_subject_t& subject) {
        std::uint64_t count = 0;
        detail::call(pfront_model_query_count, object_.get(), &subject, &count);
        return count;
    }
    span<const pfront_model_contact_t> contacts(const pfront_subject_t& subject) {
        return detail::list<pfront_model_contact_t>(pfront_model_query_contacts, object_.get(), &subject);
    }
    pfront_model_query_t* get() const noexcept { return object_.get(); }

private:
    explicit query(const pfront_executor_t* on)
        : object_(detail::made<pfront_model_query_t, pfront_model_query_free>(pfront_model_query_create, on)) {}
    detail::handle<pfront_model_query_t, pfront_model_query_free> object_;
};

// How many pairs of each subject meet; without an executor on the calling thread.
inline std::vector<std::uint64_t> batch_count(span<const pfront_subject_t> subjects, const executor* on = nullptr) {
    std::vector<std::uint64_t> counts(subjects.size());
    detail::call(pfront_batch_count, on ? on->get() : nullptr, subjects.data(), subjects.size(), counts.data());
    return counts;
}

// Some pair of each subject that meets.
inline std::vector<std::optional<pair>> batch_any(span<const pfront_subject_t> subjects, const executor* on = nullptr) {
    std::vector<pair> pairs(subjects.size());
    std::vector<std::uint32_t> found(subjects.size());
    detail::call(pfront_batch_any, on ? on->get() : nullptr, subjects.data(), subjects.size(), pairs.data(), found.data());
    std::vector<std::optional<pair>> told(subjects.size());
    for (std::size_t i = 0; i < told.size(); i++) {
        if (found[i]) told[i] = pairs[i];
    }
    return told;
}

// How far apart the models of each subject are, if at most `limit`.
inline std::vector<std::optional<pfront_gap_t>> batch_distance(span<const pfront_subject_t> subjects, float limit = INFINITY,
                                                               const executor* on = nullptr) {
    std::vector<pfront_gap_t> gaps(subjects.size());
    std::vector<std::uint32_t> found(subjects.size());
    detail::call(pfront_batch_distance, on ? on->get() : nullptr, subjects.data(), subjects.size(), limit, gaps.data(), found.data());
    std::vector<std::optional<pfront_gap_t>> told(subjects.size());
    for (std::size_t i = 0; i < told.size(); i++) {
        if (found[i]) told[i] = gaps[i];
    }
    return told;
}

// The relations of bodies, sorted, and the bodies that are no solids.
struct report {
    span<const pfront_checked_pair_t> pairs;
    span<const pfront_refused_body_t> refused;
    // Whether every pair is allowed.
    bool is_allowed() const noexcept {
        for (const auto& two : pairs) {
            if (!two.is_allowed) return false;
        }
        return true;
    }
};

// Bodies in one world, for one thread at a time. A body is a number; lists are good until the same question is asked again.
class scene {
public:
    scene() : scene(nullptr) {}
    explicit scene(const executor& on) : scene(on.get()) {}
    // Asks for pairs at most so far apart from now on; 0 for those that intersect.
    void within(float distance) { detail::call(pfront_scene_within, object_.get(), distance); }

    std::uint64_t add(const model& model, const pose& world_from_body = identity) {
        std::uint64_t body = 0;
        detail::call(pfront_scene_add, object_.get(), model.get(), &world_from_body, &body);
        return body;
    }
    void remove(std::uint64_t body) { detail::call(pfront_scene_remove, object_.get(), body); }
    void set_pose(std::uint64_t body, const pose& world_from_body) {
        detail::call(pfront_scene_set_pose, object_.get(), body, &world_from_body);
    }
    void set_pose(std::uint64_t body, const pose64& world_from_body) {
        detail::call(pfront_scene_set_pose_f64, object_.get(), body, &world_from_body);
    }
    void set_model(std::uint64_t body, const model& model) {
        detail::call(pfront_scene_set_model, object_.get(), body, model.get());
    }
    // The vertices of a body in its own frame, of float or, for a model in f64, of double: rows of three, or their numbers.
    template <class P>
    void set_positions(std::uint64_t body, const P& positions) {
        detail::set_positions(positions, pfront_scene_set_positions, pfront_scene_set_positions_f64, object_.get(), body);
    }
    void set_groups(std::uint64_t body, std::uint32_t memberships, std::uint32_t filter) {
        detail::call(pfront_scene_set_groups, object_.get(), body, memberships, filter);
    }
    void ask_itself(std::uint64_t body, bool asked = true) {
        detail::call(pfront_scene_ask_itself, object_.get(), body, std::uint32_t{asked});
    }
    void ignore(std::uint64_t a, std::uint64_t b, bool ignored = true) {
        detail::call(pfront_scene_ignore, object_.get(), a, b, std::uint32_t{ignored});
    }
    void set_user_data(std::uint64_t body, std::uint64_t user_data) {
        detail::call(pfront_scene_set_user_data, object_.get(), body, user_data);
    }
    std::uint64_t user_data(std::uint64_t body) const {
        std::uint64_t user_data = 0;
        detail::call(pfront_scene_user_data, static_cast<const pfront_scene_t*>(object_.get()), body, &user_data);
        return user_data;
    }
    span<const pfront_piece_t> split(std::uint64_t body, span<const std::uint32_t> parts) {
        return detail::list<pfront_piece_t>(pfront_scene_split, object_.get(), body, parts.data(), parts.size());
    }

    span<const hit> update() { return detail::list<hit>(pfront_scene_update, object_.get()); }
    span<const pfront_scene_contact_t> contacts() {
        return detail::list<pfront_scene_contact_t>(pfront_scene_contacts, object_.get());
    }
    span<const pfront_scene_contact64_t> contacts_f64() {
        return detail::list<pfront_scene_contact64_t>(pfront_scene_contacts_f64, object_.get());
    }
    std::optional<hit> any() { return detail::found<hit>(pfront_scene_any, object_.get()); }
    std::uint64_t count() {
        std::uint64_t count = 0;
        detail::call(pfront_scene_count, object_.get(), &count);
        return count;
    }
    // Pairs of bodies: for (const auto& [a, b] : scene.intersecting_bodies()).
    span<const std::uint64_t[2]> intersecting_bodies() {
        return detail::list<std::uint64_t[2]>(pfront_scene_intersecting_bodies, object_.get());
    }
    // The body that is nearest to one, and how far apart they are, if at most `limit`.
    std::optional<std::pair<std::uint64_t, pfront_gap_t>> distance(std::uint64_t body, float limit = INFINITY) {
        std::uint64_t nearest = 0;
        const auto gap = detail::found<pfront_gap_t>(pfront_scene_distance, object_.get(), body, limit, &nearest);
        return gap ? std::make_optional(std::make_pair(nearest, *gap)) : std::nullopt;
    }
    // The relations of all bodies whose boxes overlap; they may be apart or touch, or what `allowed` says.
    report check(const std::optional<pfront_allowed_t>& allowed = std::nullopt) {
        const pfront_checked_pair_t* pairs = nullptr;
        const pfront_refused_body_t* refused = nullptr;
        std::size_t count = 0, refused_count = 0;
        detail::call(pfront_scene_check, object_.get(), allowed ? &*allowed : nullptr, &pairs, &count, &refused, &refused_count);
        return {span<const pfront_checked_pair_t>(pairs, count), span<const pfront_refused_body_t>(refused, refused_count)};
    }
    span<const std::uint64_t> bodies_in(const std::array<float, 3>& min, const std::array<float, 3>& max) {
        return detail::list<std::uint64_t>(pfront_scene_bodies_in, object_.get(), min.data(), max.data());
    }
    // Calls `visit` with each hit until it returns true; an exception that it throws ends the visit and arrives here.
    template <class V>
    bool visit(V&& visit) {
        struct context {
            V& visit;
            std::exception_ptr thrown;

            static std::int32_t each(void* self, const hit* found) noexcept {
                auto& [visit, thrown] = *static_cast<context*>(self);
                try {
                    return visit(*found) ? 1 : 0;
                } catch (...) {
                    thrown = std::current_exception();
                    return 1;
                }
            }
        } state{visit, nullptr};
        std::uint32_t stopped = 0;
        detail::call(pfront_scene_visit, object_.get(), &context::each, static_cast<void*>(&state), &stopped);
        if (state.thrown) std::rethrow_exception(state.thrown);
        return stopped != 0;
    }
    pfront_scene_t* get() const noexcept { return object_.get(); }

private:
    explicit scene(const pfront_executor_t* on)
        : object_(detail::made<pfront_scene_t, pfront_scene_free>(pfront_scene_create, on)) {}
    detail::handle<pfront_scene_t, pfront_scene_free> object_;
};

}  // namespace pfront

#endif
