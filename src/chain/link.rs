//! Names a link by branch and number of joints from the bed; holds no pose.

/// Side of the bed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Branch {
    Workpiece = 0,
    Tool = 1,
}

/// A link: the body behind the first `depth` joints of a branch; depth 0 is the bed on either branch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LinkId {
    pub branch: Branch,
    pub depth: usize,
}

impl LinkId {
    /// The bed.
    pub const BED: LinkId = LinkId { branch: Branch::Workpiece, depth: 0 };
}
