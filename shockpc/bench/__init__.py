"""How far to trust a number, and what it costs: error against run time, measured on cases that are meant to hurt.

    cases/        what is hard, as data: families of scenes with one parameter each
    build         robots of the families, from a list of links to a file
    exact         a scene's numbers at full length: placements, inertias and rows with a hundred digits
    reference     the answer to fifty digits and more, by elimination along the tree in maximal coordinates
    accuracy      the error of every body against it
    system        what a method is given: a posture and what is held in it
    methods       the rivals, in one tuple
    simulate      landing by simulation: a stiff contact on Pinocchio's ABA …
    mujoco_peer   … and in MuJoCo
    timing        warmed up, repeated, median and quartiles
    measure       part 1 and 2 of the report: every case by every method
    percussion    part 2 also: centre and radius of percussion of bodies that hardly turn
    saving        part 3: what leaving out saves
    throughput    part 4: many postures, against peers on the same work
    compliant     one's own scene: from which stiffness on the rigid answer holds
    random_trees  trees that nobody would think of, and their landings
    soak          such trees by the thousand
    report        Markdown, CSV, JSON and figures

Nothing in the product imports this package, and what no user needs lives here and not there.
"""
