// pfront.hpp: what it returns is what C returns, errors are exceptions, and nothing leaks.

#include "pfront.hpp"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#define EXPECT(condition)                                                        \
    do {                                                                         \
        if (!(condition)) {                                                      \
            std::fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition); \
            std::exit(1);                                                        \
        }                                                                        \
    } while (false)

using rows = std::vector<std::array<float, 3>>;

static pfront::pose moved(float x) {
    pfront::pose pose = pfront::identity;
    pose.rows[0][3] = x;
    return pose;
}

static void models(const pfront::buffers& floor, const pfront::buffers& blade) {
    EXPECT(pfront::all(floor, blade).size() == 1 && pfront::all(floor, blade, moved(9)).empty());
    EXPECT(pfront::any(floor, blade)->a == 0 && !pfront::any(floor, blade, moved(9)));
    EXPECT(pfront::self(floor).empty());
    const pfront::model a(floor), b(blade);
    pfront::query query;
    const pfront::pose far = moved(9), near = moved(0);
    EXPECT(query.all(pfront::subject(a, b)).size() == 1 && query.count(pfront::subject(a, b, far)) == 0);
    EXPECT(query.any(pfront::subject(a, b)) && !query.any(pfront::subject(a)));
    EXPECT(query.contacts(pfront::subject(a, b))[0].contact.kind == PFRONT_CROSSING);
    EXPECT(query.distance(pfront::subject(a, b))->high == 0 && query.distance(pfront::subject(a, b, far))->low > 1);
    EXPECT(!query.distance(pfront::subject(a, b, far), 1));
    query.within(1e6f);
    EXPECT(query.count(pfront::subject(a, b, far)) > 0);
    query.within(0);
    const pfront_subject_t subjects[] = {pfront::subject(a, b, near), pfront::subject(a, b, far)};
    const auto counts = pfront::batch_count(subjects);
    EXPECT(counts[0] == 1 && counts[1] == 0);
    const pfront::executor on(PFRONT_CPU);
    EXPECT(pfront::batch_any(subjects, &on)[0] && !pfront::batch_any(subjects, &on)[1]);
    EXPECT(pfront::batch_distance(subjects, INFINITY, &on)[1]->low > 1 && !pfront::batch_distance(subjects, 1)[1]);
    pfront::model cloth(floor);
    const std::vector<float> elsewhere(3 * floor.vertex_count, 9);
    EXPECT(query.count(pfront::subject(a, cloth)) > 0);
    cloth.set_positions(elsewhere);
    EXPECT(query.count(pfront::subject(a, cloth)) == 0);
    const pfront::pose there = pfront::multiply(far, pfront::inverse(far));
    EXPECT(std::memcmp(&there, &near, sizeof there) == 0);
}

static void solids() {
    const rows points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const std::uint16_t sides[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const pfront::model solid(pfront::mesh(points, sides));
    pfront::query query;
    const pfront::pose still = moved(0), half = moved(0.5F), beside = moved(1);
    EXPECT(query.relation(pfront::subject(solid, solid, still)).relation == PFRONT_RELATION_EQUAL);
    EXPECT(query.relation(pfront::subject(solid, solid, half)).relation == PFRONT_RELATION_CROSSING);
    const auto [low, high] = query.overlap_volume(pfront::subject(solid, solid, half));
    EXPECT(low <= 1.0 / 48 && 1.0 / 48 <= high);
    pfront::scene scene;
    scene.add(solid);
    const auto other = scene.add(solid, beside);
    EXPECT(scene.check().is_allowed() && scene.check().pairs[0].relation == PFRONT_RELATION_TOUCHING && scene.check().refused.empty());
    scene.set_pose(other, half);
    EXPECT(!scene.check().is_allowed() && scene.check(pfront_allowed_t{0, 0.1, 0}).is_allowed());
    const std::uint16_t open[] = {0, 2, 1};
    const pfront::model sheet(pfront::mesh(points, open));
    try {
        query.relation(pfront::subject(solid, sheet, still));
        EXPECT(false);
    } catch (const pfront::error& error) {
        EXPECT(error.detail.status == PFRONT_OPEN_EDGE && std::strcmp(error.detail.what, "b") == 0);
    }
}

static void scenes(const pfront::buffers& floor, const pfront::buffers& blade) {
    const pfront::executor on(PFRONT_CPU);
    pfront::scene scene(on);
    pfront::model model(floor);
    const std::uint64_t a = scene.add(model);
    model = pfront::model(blade);  // the scene keeps what its bodies need
    const std::uint64_t b = scene.add(model);
    scene.set_user_data(b, 7);
    EXPECT(scene.user_data(b) == 7);
    EXPECT(scene.update().size() == 1 && scene.count() == 1 && scene.any()->bodies[1] == b && scene.contacts().size() == 1);
    EXPECT(scene.contacts_f64()[0].is_flat == 0);
    for (const auto& [first, second] : scene.intersecting_bodies()) EXPECT(first == a && second == b);
    EXPECT(scene.distance(a)->first == b && scene.distance(a)->second.high == 0);
    EXPECT(scene.bodies_in({-1, -1, -1}, {5, 5, 5}).size() == 2);
    EXPECT(scene.visit([](const pfront::hit& hit) { return hit.pair.a == 0; }));
    try {
        scene.visit([](const pfront::hit&) -> bool { throw 42; });
        EXPECT(false);
    } catch (int thrown) {
        EXPECT(thrown == 42);
    }
    pfront::scene taken = std::move(scene);
    taken.ignore(a, b);
    EXPECT(!taken.any());
    taken.ignore(a, b, false);
    taken.set_pose(b, moved(9));
    EXPECT(taken.count() == 0);
    taken.within(0);
    taken.set_pose(b, pfront::pose64{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}});
    EXPECT(taken.count() == 1);
    taken.set_positions(a, rows{{0, 0, 5}, {4, 0, 5}, {0, 4, 5}});
    taken.ask_itself(a);
    EXPECT(taken.count() == 0);
    taken.set_model(a, pfront::model(floor));
    taken.set_groups(a, 1, 1);
    const std::uint32_t parts[] = {0};
    EXPECT(taken.split(a, parts)[0].triangle_count == 1 && taken.count() == 1);
    taken.remove(b);
    try {
        taken.remove(b);
        EXPECT(false);
    } catch (const pfront::error& error) {
        EXPECT(error.detail.status == PFRONT_STALE_BODY && std::strlen(error.what()) > 10);
    }
}

int main() {
    const rows points = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
    const float others[] = {1, 1, -1, 1, 2, -1, 1, 1, 1};
    const std::array<std::uint16_t, 3> corners = {0, 1, 2};
    const std::vector<std::array<std::uint32_t, 3>> wide = {{0, 1, 2}};
    const auto floor = pfront::mesh(points, corners), blade = pfront::mesh(others, wide);
    models(floor, blade);
    solids();
    scenes(floor, blade);
    const double doubles[] = {0, 0, 0, 4, 0, 0, 0, 4, 1e-300};
    EXPECT(pfront::query().count(pfront::subject(pfront::model::from_f64(pfront::mesh(doubles, wide)))) == 0);
    const std::array<std::uint32_t, 3> beyond = {0, 1, 3};
    try {
        pfront::model model(pfront::mesh(points, beyond));
        EXPECT(false);
    } catch (const pfront::error& error) {
        EXPECT(error.detail.status == PFRONT_NO_SUCH_VERTEX && error.detail.given == 3);
    }
    try {
        pfront::model::from_blob({});
        EXPECT(false);
    } catch (const pfront::error&) {
    }
    EXPECT(std::strcmp(pfront::version(), PFRONT_VERSION) == 0);
    std::puts("ok");
}
