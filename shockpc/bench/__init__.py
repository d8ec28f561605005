"""Error against run time of several methods on stiff and extreme landings.

    cases         families of landings with one parameter each
    build         their robots
    system        what a method is given
    methods       the methods: the package, numpy, Pinocchio
    mujoco_peer   landing simulated in MuJoCo, and the impulsive equation with its matrices
    measure       error and run time of every method on a case
    throughput    many postures against Pinocchio and MuJoCo
    costs         run time of an analysis, of the command and of sweeps
    report        chart, tables, Markdown and CSV
    run           the suite, and one landing of one's own

Nothing else in the package but the command line imports it.
"""
